"""The joints that open in a motion: those whose bodies move against each other."""

from collections.abc import Collection
from math import hypot
from typing import TypeAlias

import numpy as np

from stability.model import BodyId, Vec3
from stability.problem import Contact, Motion, Placed, Problem

Pair: TypeAlias = frozenset[BodyId]  # two bodies with a joint

YIELDS = 1e-3  # share of the fastest relative motion of the bodies of a joint
STILL = 1e-6  # share of the fastest brick: no joint yields


def joined_pairs(contacts: Collection[Contact]) -> set[Pair]:
    """Return the pairs of bodies with a joint."""
    return {frozenset((contact.lower, contact.upper)) for contact in contacts if not contact.law.is_cone}


def opened_pairs(problem: Problem, motion: Motion) -> set[Pair]:
    """Return the pairs of bodies whose joint opens in a motion."""
    joined = [contact for contact in problem.contacts if not contact.law.is_cone]
    speeds = [_parting(problem, motion, contact) for contact in joined]
    fastest = max((fastest_point(problem.bricks[name], *twist) for name, twist in motion.velocity.items()), default=0.0)
    least = max(YIELDS * max(speeds, default=0.0), STILL * fastest)
    return {frozenset((c.lower, c.upper)) for c, speed in zip(joined, speeds, strict=True) if speed > least}


def held_pairs(problem: Problem, motion: Motion | None) -> set[Pair]:
    """Return the pairs of bricks of a problem whose joint does not open in a motion; None if it is not known."""
    pairs = {pair for pair in joined_pairs(problem.contacts) if pair <= problem.bricks.keys()}
    return pairs if motion is None else pairs - opened_pairs(problem, motion)


def _parting(problem: Problem, motion: Motion, contact: Contact) -> float:
    """Return the greatest relative speed at the points of a contact."""
    parting = np.zeros((len(contact.points_W), 3))
    for name, sign in ((contact.upper, 1.0), (contact.lower, -1.0)):
        if name in motion.velocity and name in problem.bricks:
            velocity, spin = motion.velocity[name]
            arms = np.array(contact.points_W) - problem.bricks[name].pose.position_W
            parting += sign * (np.array(velocity) + np.cross(spin, arms))
    return float(np.linalg.norm(parting, axis=1).max())


def fastest_point(placed: Placed, velocity: Vec3, spin: Vec3) -> float:
    """Return an upper bound of the speed of the points of a brick."""
    return hypot(*velocity) + placed.brick.shape.bounding_radius * hypot(*spin)
