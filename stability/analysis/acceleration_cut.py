"""Finds the greatest acceleration in one direction and the limit that its mechanism sets in all directions."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import cos, hypot, inf, sin

import numpy as np

from stability.contacts.bodies import AnySolid, Solid, convex_parts, solid
from stability.contacts.detection import flush_within
from stability.geometry.box_distance import gap_bridged, reach_between
from stability.geometry.rows import Array
from stability.graph import components
from stability.model import BodyId
from stability.problem import ZERO, Contact, Motion, Problem, Tolerances, Wrench
from stability.statics.conic_program import ConicProgram, clarabel_solve, quick_solve
from stability.statics.equilibrium import proven_forces, proven_motion
from stability.statics.proof import MotionCheck, ProofCones, check_forces, check_motion, proof_cones
from stability.statics.round_borders import inscribed
from stability.statics.wrench_matrix import WrenchMatrix, wrench_matrix

# Sliver contacts: faces that overlap by almost nothing. A margin must not depend on them.
#
# A sliver carries load like any contact of rigid bodies (docs/design/contacts.md), so a verdict counts on it. A margin
# must not depend on an overlap of a hundredth of a millimetre between cartons that were meant to be flush.


def without_slivers(problem: Problem) -> Problem:
    """Return the problem without sliver contacts, or the problem itself if it has none.

    A contact is a sliver if its bodies would be flush after a displacement of less than a thousandth of the smallest
    side of the thinner one.
    """
    solids = {name: solid(placed) for name, placed in problem.bricks.items()}
    kept = [contact for contact in problem.contacts if not _is_sliver(contact, solids)]
    return problem if len(kept) == len(problem.contacts) else replace(problem, contacts=kept)


def _is_sliver(contact: Contact, solids: dict[BodyId, AnySolid]) -> bool:
    if contact.lower not in solids or contact.upper not in solids:
        return False
    a, b = solids[contact.lower], solids[contact.upper]
    reach = reach_between(a.shortest, b.shortest)
    overlap = gap_bridged(reach, 0.0)
    return any(
        flush_within(part, other, reach, overlap)
        for part, other in product(convex_parts(a), convex_parts(b))
        if _holds(part, contact, reach) and _holds(other, contact, reach)
    )


def _holds(part: Solid, contact: Contact, reach: float) -> bool:
    """Return whether the points of a contact lie in the bounding box of a part, up to the tolerance of contacts."""
    return all(
        low - reach <= along <= high + reach
        for point in contact.points_W
        for low, along, high in zip(part.low_W, point, part.high_W, strict=True)
    )


# The prestress that contacts need to balance the loads, or have in reserve.
#
# It is the least s with forces that balance the loads if each normal force counts for s more than its value: |f_t| <=
# mu (f_n + s c), where c is the load capacity of the contact's upper brick. If s < 0, the forces lie deep inside their
# cones. If s > 0, no forces lie inside, and the dual motion proves it. The program is solved over velocities, as in
# `equilibrium`: it maximises the power of the loads minus the separation of all contacts; its duals are the forces.


ACCURACY = 1e-11  # requested accuracy of the solver
ROUGH = 1e-8  # an accuracy that needs no iterative refinement of the steps


@dataclass(frozen=True, slots=True, eq=False)
class Prestress:
    """Result of the solver, not a proof until it is checked by plain arithmetic."""

    least: float  # in units of the load capacities of the upper bricks; never below -1
    rows: Array  # (rows,) forces; within their cones if `least` is not positive
    columns: Array  # (columns,) velocities; a proof of instability if `least` is positive
    sliding: float  # power of tangential forces on slips; never positive


def least_prestress(system: WrenchMatrix, accuracy: float = ACCURACY) -> Prestress:
    """Return the least prestress that balances the loads; `accuracy` is requested of the solver."""
    from scipy.sparse import csc_matrix, vstack  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    normal = np.zeros(len(system.row_scale))
    normal[system.rows.normals] = 1.0
    separation = system.matrix.T @ normal
    program = system.rows.program(
        -(system.loads + separation),
        # The separation is bounded, so that its dual, the prestress, is at least -1.
        vstack([-system.matrix, csc_matrix(separation)], format="csc"),
        np.append(np.zeros(len(normal)), 1.0),
        positive=1,
    )
    point = (clarabel_solve if accuracy < ROUGH else quick_solve)(program, accuracy)
    pressed, least = point.dual[:-1], float(point.dual[-1]) - 1.0
    slips = system.matrix @ point.x
    sliding = float(np.where(normal > 0.0, 0.0, pressed * slips).sum())
    return Prestress(least, pressed - least * normal, point.x, sliding)


# The greatest acceleration in one direction, and the bound that its mechanism sets in all directions.
#
# One conic program over velocities u minimises the resistance of the loads to a motion with unit gain in the direction,
# among all motions that no contact resists. Its value is the reach; its duals are the forces at the reach. Each such
# motion bounds all directions: an acceleration a of the masses has the power p.a, with p the momentum of the motion,
# and admissible forces exist only if this power is at most the resistance of the loads.


FURTHEST = 1e3  # [g] a structure that survives this much is held on all sides
# The factors below multiply the least share of the rest forces that brings other forces into their cones; they are
# tried in turn.
SURELY = 1.0 + 1e-6  # margin for rounding
MORE = tuple(2.0**exponent for exponent in range(40))
LEAST = 2.0**-40  # a smaller share is rounding
TOO_MUCH = 0.01  # a share this large shows a structure at its limit: even its rest forces are not deep in their cones
AT_THE_BRINK = (1e-9, 1e-6, 1e-3)  # shares for a structure at its limit
FAINT = 1e-3  # share of usual forces by which contacts with zero pressure take part in a correction
MENDINGS = 2  # the second removes the rounding error of the first
# [g] by which a cut is first moved outwards from the solver's value; then by multiples of the gain that a proof needs
FURTHER = (1e-4, 1e-2)
CLOSER = (1.1, 4.0, 16.0, 64.0, 256.0, 1024.0)


@dataclass(frozen=True, slots=True, eq=False)
class AcceleratedProblem:
    """Problem prepared for many directions. Accelerations are in units of g."""

    problem: Problem
    weights: Mapping[BodyId, float]  # [N] of each brick: the pull of a horizontal acceleration of 1 g
    system: WrenchMatrix
    rest: Array  # (rows,) forces that balance the loads without acceleration
    tolerances: Tolerances
    cones: ProofCones | None  # for proof checks; they do not depend on the acceleration

    def pull(self, x: float, y: float) -> dict[BodyId, Wrench]:
        """Return the inertial forces of an acceleration."""
        return {name: Wrench((weight * x, weight * y, 0.0)) for name, weight in self.weights.items()}

    def loaded(self, x: float, y: float) -> Problem:
        """Return the problem with the inertial forces of an acceleration."""
        loads = dict(self.problem.loads)
        for name, wrench in self.pull(x, y).items():
            load = loads.get(name, Wrench(ZERO))
            (fx, fy, fz), (px, py, _) = load.force_W, wrench.force_W
            loads[name] = Wrench((fx + px, fy + py, fz), load.torque_W)
        return replace(self.problem, loads=loads)

    def at(self, x: float, y: float) -> WrenchMatrix:
        """Return the wrench matrix with the inertial forces of an acceleration."""
        return replace(self.system, loads=self.system.wrench_of(self.loaded(x, y).loads) + self.system.pulls)

    def holds(self, x: float, y: float, rows: Array) -> bool:
        """Return whether forces, in the units of the rows, are proven to balance the loads under an acceleration."""
        return check_forces(self.loaded(x, y), self.system.forces(rows), self.tolerances, self.cones).holds

    def falls(self, x: float, y: float, motion: Motion) -> MotionCheck:
        """Return the check of whether a motion gains power from the loads under an acceleration."""
        return check_motion(self.loaded(x, y), motion, self.tolerances, self.cones)


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """Half-plane that contains all survivable accelerations, and the motion that proves it."""

    normal: tuple[float, float]  # unit, outward
    distance: float  # from zero acceleration, by the solver [g]
    # the proven distance exceeds `distance` by at most this [g] (`proven_distance` may find less); 0 if exact
    further: float
    motion: Motion


@dataclass(frozen=True, slots=True, eq=False)
class Heading:
    """Result in one direction."""

    angle: float  # bearing from x towards y [rad]
    reach: float  # [g] proven by forces
    rows: Array  # (rows,) forces that prove the reach
    slips: Array  # (rows,) slips of the limiting motion
    cut: Cut | None  # None if nothing limits the direction or no motion was proven

    @property
    def point(self) -> tuple[float, float]:
        """Return the acceleration reached."""
        return (self.reach * cos(self.angle), self.reach * sin(self.angle))


def shaken(
    problem: Problem, gravity: float | None, tolerances: Tolerances, accuracy: float = ACCURACY
) -> AcceleratedProblem | None:
    """Return a problem prepared for accelerations; None if it is not proven to stand.

    Polygons inside round contacts stand for these: a motion must clear the whole contact, and the first polygons are
    2 % short of it. Slivers are left out if the structure stands without them (`without_slivers`). Without `gravity`
    the weight of a brick is the vertical part of its load. `accuracy` is requested of the solver.
    """
    problem = inscribed(problem)
    sure = without_slivers(problem)
    case = _shaken(sure, gravity, tolerances, accuracy)
    return case if case is not None or sure is problem else _shaken(problem, gravity, tolerances, accuracy)


def weights_of(problem: Problem, gravity: float | None) -> dict[BodyId, float]:
    """Return the weight of each brick [N]; without `gravity` [m/s2], the vertical part of its load."""
    if gravity is None:
        return {name: -load.force_W[2] for name, load in sorted(problem.loads.items())}
    return {name: gravity * placed.brick.mass for name, placed in sorted(problem.bricks.items())}


def _shaken(
    problem: Problem, gravity: float | None, tolerances: Tolerances, accuracy: float
) -> AcceleratedProblem | None:
    weights = weights_of(problem, gravity)
    system = wrench_matrix(problem, whole=True)
    rest = corrected_forces(
        system, least_prestress(system, accuracy).rows
    )  # deep inside the cones, so that a share of these forces brings others inside
    stands = proven_forces(problem, system, rest, tolerances) is not None
    return AcceleratedProblem(problem, weights, system, rest, tolerances, proof_cones(problem)) if stands else None


def heading(case: AcceleratedProblem, angle: float) -> Heading:
    """Return the greatest acceleration of the assembly in one direction."""
    point = clarabel_solve(program_along(case, angle), ACCURACY)
    if not (np.isfinite(point.x).all() and np.isfinite(point.dual).all()):
        return Heading(angle, 0.0, case.rest, np.zeros(len(case.rest)), None)
    along = (cos(angle), sin(angle))
    value = max(0.0, -float(point.dual[0]))
    reach, rows = proven_reach(case, along, value, point.dual[1:-1])
    return Heading(angle, reach, rows, case.system.matrix @ point.x[:-1], _cut(case, along, value, point.x[:-1]))


def program_along(case: AcceleratedProblem, angle: float) -> ConicProgram:
    """Return the program of one direction.

    Minus its first dual is the reach [g]; the other duals except the last are the forces.
    """
    from scipy.sparse import bmat, csr_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    system = case.system
    along = system.wrench_of(case.pull(cos(angle), sin(angle)))
    columns = len(along)
    # Zero entries are stored too, so that the programs of all directions have the same sparsity pattern.
    gained = csr_matrix((along, np.arange(columns), (0, columns)), shape=(1, columns))
    # The last column covers the rest of the unit gain at the highest price, so that the reach is finite.
    matrix = bmat([[gained, [[1.0]]], [-system.matrix, None], [None, [[-1.0]]]], format="csc")
    offset = np.append(1.0, np.zeros(len(system.row_scale) + 1))
    return system.rows.program(np.append(-system.loads, FURTHEST), matrix, offset, equal=1, positive=1)


def proven_reach(
    case: AcceleratedProblem, along: tuple[float, float], value: float, rows: Array
) -> tuple[float, Array]:
    """Return the reach that forces prove, a little below the solver's value if needed, and these forces.

    At the reach itself some contacts are about to open, so correcting rounding errors pushes other forces out of their
    cones. Mixing in a share of the rest forces, which lie deep inside, brings all forces back in and lowers the reach
    by the same share.
    """
    system = case.at(value * along[0], value * along[1])
    balanced = corrected_forces(system, rows)
    shares = list(_shares(case, balanced))
    at_the_brink = not shares or shares[0] > TOO_MUCH
    reach, proven = _at_the_brink(case, along, value, balanced) if at_the_brink else (0.0, case.rest)
    if reach > 0.0:
        return reach, proven
    for share in shares:
        mixed = balanced + share * (case.rest - balanced)
        reach = value * (1.0 - share)
        if case.holds(reach * along[0], reach * along[1], mixed):
            return reach, mixed
    return 0.0, case.rest


def _at_the_brink(
    case: AcceleratedProblem, along: tuple[float, float], value: float, balanced: Array
) -> tuple[float, Array]:
    """Return the reach for a structure at its limit, where mixing cannot correct contacts with zero pressure.

    The forces are projected into their cones one by one and balanced again by the contacts with pressure.
    """
    for share in AT_THE_BRINK:
        x, y = ((1.0 - share) * value * part for part in along)
        mixed = balanced + share * (case.rest - balanced)
        forces = proven_forces(case.loaded(x, y), case.at(x, y), mixed, case.tolerances)
        if forces is not None:
            each = [force for of_contact in forces.of_contacts for of_point in of_contact for force in of_point]
            return (1.0 - share) * value, case.system.rows_of(np.array(each))
    return 0.0, case.rest


def _shares(case: AcceleratedProblem, balanced: Array) -> Iterator[float]:
    """Yield the shares of the rest forces that bring other forces into their cones, the smallest share first."""
    least = case.system.rows.least_share(balanced, case.rest)
    if least == 0.0:
        yield 0.0
    least = max(SURELY * least, LEAST)
    yield from (more * least for more in MORE if more * least < 1.0)


def corrected_forces(system: WrenchMatrix, rows: Array) -> Array:
    """Return the nearest balancing forces, ignoring cones; contacts with higher pressure change more."""
    from scipy.sparse import diags, identity  # noqa: PLC0415 -- slow to import, and most verdicts need no solver
    from scipy.sparse.linalg import splu  # noqa: PLC0415 -- likewise

    weight = FAINT + np.abs(system.rows.by_row(rows[system.rows.normals]))
    weighted = diags(weight) @ system.matrix
    square = (system.matrix.T @ weighted + FAINT**4 * identity(len(system.loads))).tocsc()
    # The matrix is symmetric and positive definite, so no pivoting is needed, which saves a third of the time.
    solve = splu(square, "MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve
    for _ in range(MENDINGS):
        rows = rows - weighted @ solve(system.matrix.T @ rows + system.loads)
    return rows


def _cut(case: AcceleratedProblem, along: tuple[float, float], value: float, columns: Array) -> Cut | None:
    """Return the half-plane that a motion proves, a little outside the solver's one: a proof needs a positive gain."""
    if value > 0.5 * FURTHEST:
        return None
    for further in FURTHER:
        x, y = ((value + further) * part for part in along)
        loaded = case.loaded(x, y)
        motion = proven_motion(loaded, case.at(x, y), columns, case.tolerances)
        if motion is not None:
            break
    else:
        return None
    momentum = np.zeros(2)
    for name, (velocity, _) in sorted(motion.velocity.items()):
        momentum += case.weights.get(name, 0.0) * np.array(velocity[:2])
    size = hypot(*momentum)
    normal = (float(momentum[0]) / size, float(momentum[1]) / size)
    share = along[0] * normal[0] + along[1] * normal[1]
    return Cut(normal, value * share, further * share, motion)


def proven_distance(case: AcceleratedProblem, cut: Cut) -> float:
    """Return the least distance of a cut that its motion proves [g]; the required gain is found by trial."""
    x, y = cut.normal
    furthest = cut.distance + cut.further
    if cut.further == 0.0:
        return furthest
    gained = case.falls(furthest * x, furthest * y, cut.motion).gain
    for multiple in CLOSER if gained > 0.0 else ():
        distance = cut.distance + cut.further * min(1.0, multiple * case.tolerances.gain / gained)
        if case.falls(distance * x, distance * y, cut.motion).holds:
            return distance
    return furthest


def distance_of(cut: Cut | None) -> float:
    """Return the distance of a cut from zero acceleration [g]; infinite if there is no cut."""
    return inf if cut is None else cut.distance


# Groups of bricks without contact to each other, directly or through other bricks: they shake independently.


def groups_apart(problem: Problem) -> list[Problem]:
    """Return the groups of bricks without contact to each other, each with its contacts and loads."""
    touching: dict[BodyId, set[BodyId]] = {name: set() for name in problem.bricks}
    for contact in problem.contacts:
        if contact.lower in touching and contact.upper in touching:
            touching[contact.lower].add(contact.upper)
            touching[contact.upper].add(contact.lower)
    groups = []
    for members in components(problem.bricks, touching.__getitem__):
        groups.append(
            replace(
                problem,
                bricks={name: placed for name, placed in problem.bricks.items() if name in members},
                contacts=[each for each in problem.contacts if each.lower in members or each.upper in members],
                loads={name: load for name, load in problem.loads.items() if name in members},
            )
        )
    return groups
