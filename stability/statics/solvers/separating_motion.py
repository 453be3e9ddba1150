"""Separating motions: they open contacts strictly.

If some motion opens all contacts, the only contact forces that balance each other are none at all.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from math import hypot, inf

import numpy as np

from stability.geometry.vectors import scale
from stability.model import BodyId, Vec3
from stability.statics.facts import ZERO, Motion, Problem
from stability.statics.proof import least_separating_speed
from stability.statics.solvers.conic_program import Array, ConicProgram, Solver, clarabel_solve, solve
from stability.statics.solvers.wrench_matrix import WrenchMatrix, wrench_matrix

# Of the speed there: a contact that opens more slowly may be closed by what is not known of the geometry.
SEPARATES = 1e-6
SPREAD = 0.5  # how much of the friction that a rise leaves free its sideways spread may use up
# Times the number of bricks: how much faster a brick may move than the slowest contact opens. In a row of leaning
# planks each moves faster than the one before, so height is no measure.
ROOM = 10.0
LAYER = 0.01  # share of the smallest side: centres as level as this are of one layer
ACCURACY = 1e-9  # what the solver is asked for; what is found is checked


@dataclass(frozen=True, slots=True)
class ContactSeparation:
    """A motion, and how far it opens each contact of a problem: from 0 for not at all to 1."""

    motion: Motion
    of_contacts: tuple[float, ...]


def separating_motion(problem: Problem, solver: Solver = clarabel_solve) -> Motion | None:
    """A motion that is proven to open every contact strictly; None if none is found."""
    rising = next(_opening(problem), None)
    if rising is not None:
        return rising
    widest = widest_separation(problem, solver)
    if widest is None or least_separating_speed(problem, widest.motion) < SEPARATES:
        return None
    return widest.motion


def separating_velocities(problem: Problem, moving: Collection[BodyId]) -> Mapping[BodyId, Vec3] | None:
    """Velocities, none faster than 1, that open every contact of some bricks strictly while the rest stays; or None."""
    bricks = {name: problem.bricks[name] for name in sorted(moving)}
    contacts = [c for c in problem.contacts if c.lower in bricks or c.upper in bricks]
    part = replace(problem, bricks=bricks, contacts=contacts)
    for motion in _opening(part):
        fastest = max(hypot(*velocity) for velocity, _ in motion.velocity.values())
        return {name: scale(1.0 / fastest, velocity) for name, (velocity, _) in motion.velocity.items()}
    return None


def _opening(problem: Problem) -> Iterator[Motion]:
    """The motions of those that are tried without a solver that open every contact."""
    for ranks in (stack_ranks(problem), layers(problem)):
        for spread in (0.0, SPREAD):
            motion = _rising(problem, ranks, spread)
            if least_separating_speed(problem, motion) >= SEPARATES:
                yield motion


def _rising(problem: Problem, ranks: Mapping[BodyId, int], spread: float) -> Motion:
    """All bricks move up, those of a higher rank the faster, and sideways from the middle."""
    centres = [placed.pose.position_W for placed in problem.bricks.values()]
    middle = (
        tuple(0.5 * (min(c[i] for c in centres) + max(c[i] for c in centres)) for i in (0, 1)) if centres else (0, 0)
    )
    reach = max((hypot(c[0] - middle[0], c[1] - middle[1]) for c in centres), default=0.0)
    most = max((contact.friction for contact in problem.contacts), default=0.0)
    rate = spread / (max(most, 1.0) * reach) if reach > 0.0 else 0.0

    def velocity(name: BodyId) -> Vec3:
        x, y, _ = problem.bricks[name].pose.position_W
        return (rate * (x - middle[0]), rate * (y - middle[1]), float(ranks[name]))

    return Motion({name: (velocity(name), ZERO) for name in problem.bricks})


def stack_ranks(problem: Problem) -> Mapping[BodyId, int]:
    """One more than the highest rank of what a brick rests on, by the height of centres where bricks lean in a ring."""
    heights = {name: placed.pose.position_W[2] for name, placed in problem.bricks.items()}
    below: dict[BodyId, list[BodyId]] = {name: [] for name in heights}
    for contact in problem.contacts:
        if contact.upper in below and contact.lower in below:
            below[contact.upper].append(contact.lower)
    ranks: dict[BodyId, int] = {}
    for name in sorted(heights, key=lambda brick: (heights[brick], brick)):
        level = heights[name]
        ranks[name] = 1 + max(
            (ranks[lower] for lower in below[name] if heights[lower] < level and lower in ranks), default=0
        )
    return ranks


def layers(problem: Problem) -> Mapping[BodyId, int]:
    """Which layer of centres each brick is in, from the lowest on.

    Side by side, bricks of one layer rise alike, whether or not what they rest on is a part of the problem.
    """
    ranks: dict[BodyId, int] = {}
    rank, top = 0, -inf
    for name in sorted(problem.bricks, key=lambda brick: (problem.bricks[brick].pose.position_W[2], brick)):
        placed = problem.bricks[name]
        height = placed.pose.position_W[2]
        if height > top + LAYER * placed.brick.shape.least_thickness:
            rank, top = rank + 1, height
        ranks[name] = rank
    return ranks


def widest_separation(problem: Problem, solver: Solver = clarabel_solve) -> ContactSeparation | None:
    """The motion that opens contacts most, each counted up to a limit: those that it leaves shut, no motion opens."""
    system = wrench_matrix(problem, whole=True, carried=dict.fromkeys(problem.bricks, 1.0))
    room = ROOM * (1 + len(problem.bricks))
    point = solve(_program(system, len(problem.contacts), room), ACCURACY, solver)
    if isinstance(point, str) or not np.isfinite(point.x).all():
        return None
    columns = len(system.loads)
    separations = np.clip(point.x[columns:], 0.0, 1.0)
    return ContactSeparation(system.motion(point.x[:columns]), tuple(separations.tolist()))


def _program(system: WrenchMatrix, contacts: int, room: float) -> ConicProgram:
    """The largest sum of separations, one a contact and each from 0 to 1, at a speed of up to `room`."""
    from scipy.sparse import bmat, csc_matrix, identity  # noqa: PLC0415 -- slow to import, and few need to ask

    rows, columns = system.matrix.shape
    of_contact = np.repeat(np.arange(contacts), [points * normals for points, normals in system.cones.shapes])
    held, flat = 3 * len(system.round), len(system.flat)
    normals = np.append(np.arange(0, held, 3), np.arange(held, rows))
    which = of_contact[np.append(system.round, system.flat)]
    separation = csc_matrix((np.ones(len(normals)), (normals, which)), shape=(rows, contacts))
    speed, each = identity(columns), identity(contacts)
    matrix = bmat(
        [[-system.matrix, separation], [speed, None], [-speed, None], [None, each], [None, -each]], format="csc"
    )
    offset: Array = np.concatenate([np.zeros(rows), np.full(2 * columns, room), np.ones(contacts), np.zeros(contacts)])
    cost = np.append(np.zeros(columns), np.full(contacts, -1.0))
    return ConicProgram(cost, matrix, offset, 0, [3] * len(system.round), flat + 2 * columns + 2 * contacts)
