"""Refinement of contacts with round borders where a verdict needs it.

Forces at the corners of an inner polygon prove that bricks stand. If they do not balance the loads, some motion meets
no resistance at these corners. Where it closes the contact between them, it needs more corners. With these the motion
comes close to one that meets no resistance at all, which proves that the bricks fall, or there are forces.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import atan2

import numpy as np

from stability.geometry.round_patch import TURN, Disc, RoundPatch
from stability.geometry.rows import Array
from stability.problem import Contact, Motion, Problem, Tolerances
from stability.statics.equilibrium import leading_motion
from stability.statics.proof import check_motion, contact_shortfall, power

SAMPLES = 128  # angles of an arc in the search for its worst point
NEAR = 9  # angles of a closer search
ZOOMS = 6  # of the search
LEAST_ANGLE = 1e-4  # [rad] between corners: a hundred-millionth of the radius between the polygons
CLOSES = 1e-12  # share of the speed: a contact that closes more slowly counts as shut
IDLE = 1e-12  # of the power of all loads at their speeds: a smaller one is none
PEAKS = 3  # corners that one motion adds to an arc
MOST_ROUNDS = 24


SIDES = 128  # of the polygons that margins use; the apothem of an inner one is 0.03 % less than the radius
FEWER_SIDES = 48  # the same, of problems with many round borders: 0.2 %
MANY_BORDERS = 32


def inscribed(problem: Problem) -> Problem:
    """Return the problem with contacts within regular polygons inside their round borders.

    Forces that balance it lie inside the true contacts, too, so what it bears is a lower bound. A problem without
    round contacts is returned as it is.
    """
    if not problem.is_round:
        return problem
    sides = _sides(problem)
    return replace(problem, contacts=[inscribed_contact(each, sides) for each in problem.contacts])


def circumscribed(problem: Problem) -> Problem:
    """Return the problem with contacts within regular polygons around their round borders.

    Forces inside the true contacts lie inside these, too, so what it bears is an upper bound.
    """
    sides = _sides(problem)
    return replace(problem, contacts=[_circumscribed(each, sides) for each in problem.contacts])


def inscribed_contact(contact: Contact, sides: int = SIDES) -> Contact:
    """Return a contact within regular polygons inside its round borders; the same one if it has none."""
    return contact if contact.patch is None else replace(_with_sides(contact, contact.patch, sides), patch=None)


def _circumscribed(contact: Contact, sides: int) -> Contact:
    if contact.patch is None:
        return contact
    fine = _with_sides(contact, contact.patch, sides)
    return replace(fine, points_W=fine.around_W, gaps=(), patch=None)


def _sides(problem: Problem) -> int:
    many = sum(contact.patch is not None for contact in problem.contacts) > MANY_BORDERS
    return FEWER_SIDES if many else SIDES


def _with_sides(contact: Contact, patch: RoundPatch, sides: int) -> Contact:
    """Return a contact with evenly spaced corners on its arcs, beside those that it has; the same one if it has all."""
    closer = patch.with_sides(sides)
    return contact if closer == patch else contact.refined(closer)


def refined(problem: Problem, tolerances: Tolerances) -> list[tuple[Contact, Contact]]:
    """Return the contacts that need new corners for the proof of a problem, each with its refinement.

    With joints no motion tells where, so all round borders get evenly spaced ones.
    """
    first = list(problem.contacts)
    if problem.has_joints:
        closer = ((old, _with_sides(old, old.patch, SIDES)) for old in first if old.patch is not None)
        return [(old, new) for old, new in closer if new is not old]
    for _ in range(MOST_ROUNDS):
        motion = leading_motion(problem)
        if motion is None or power(problem.loads, motion) <= 0.0 or check_motion(problem, motion, tolerances).holds:
            break
        contacts = [_with_corners(contact, problem, motion) for contact in problem.contacts]
        if all(new is old for new, old in zip(contacts, problem.contacts, strict=True)):
            break
        problem = replace(problem, contacts=contacts)
    return [(old, new) for old, new in zip(first, problem.contacts, strict=True) if new is not old]


def _with_corners(contact: Contact, problem: Problem, motion: Motion) -> Contact:
    """Return a contact with corners where a motion closes it; itself if it needs none."""
    patch = contact.patch
    if patch is None:
        return contact
    angles = tuple(tuple(_distinct(each, patch, i)) for i, each in enumerate(_closing(contact, patch, problem, motion)))
    return contact.refined(patch.refined(angles)) if any(angles) else contact


def _distinct(angles: Sequence[float], patch: RoundPatch, disc: int) -> Iterator[float]:
    """Yield the angles that are far enough from all known corners and from each other."""
    x, y = patch.discs[disc].x, patch.discs[disc].y
    known = [atan2(py - y, px - x) % TURN for px, py in patch.inner]
    for angle in angles:
        if all(abs((angle - other + 0.5 * TURN) % TURN - 0.5 * TURN) > LEAST_ANGLE for other in known):
            known.append(angle)
            yield angle


def _closing(contact: Contact, patch: RoundPatch, problem: Problem, motion: Motion) -> list[list[float]]:
    """Return for each disc the angles of points of arcs at which a motion closes the contact fastest."""
    found: list[list[float]] = []
    for disc, arcs in zip(patch.discs, patch.arcs, strict=True):

        def values_at(angles: Array, disc: Disc = disc) -> Array:
            points = np.array(patch.placed(tuple(disc.at(angle) for angle in angles.tolist())))
            values, speed = contact_shortfall(contact, points, problem, motion)
            return values - CLOSES * speed

        worst: list[float] = []
        for start, end in arcs:
            at = np.linspace(start, end, SAMPLES)
            values = values_at(at)
            peaks = [i for i in range(1, SAMPLES - 1) if values[i - 1] <= values[i] >= values[i + 1]]
            for peak in sorted(peaks, key=lambda i: -values[i])[:PEAKS]:
                low, high = at[peak - 1], at[peak + 1]
                for _ in range(ZOOMS):
                    near = np.linspace(low, high, NEAR)
                    values_near = values_at(near)
                    best = int(values_near.argmax())
                    low, high = near[max(0, best - 1)], near[min(NEAR - 1, best + 1)]
                if float(values_near[best]) > 0.0:
                    worst.append(float(near[best]) % TURN)
        found.append(worst)
    return found
