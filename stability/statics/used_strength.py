"""The strength that a structure uses: the least factor on the strengths of its bricks with which it stands.

A contact under a bounded pressure p bears every field of pressures between 0 and p, and a brick carries at most its
stack load. Forces within t times these bounds balance the loads for some least t, the used share: up to one the
structure stands, above one it crushes. This is limit analysis: a motion at which bricks give way proves that t is at
least the power of the loads over the power that crushing takes.

The pressure field is uniform in each of many triangles. Those through which the border of the crushed area of the last
motion passes are cut along it, so both bounds close in on the exact field, such as the stress block of a block under an
eccentric load.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np

from stability.contact_law import OtherLawError
from stability.geometry.polygons import between
from stability.geometry.rows import Array, Indices
from stability.geometry.vectors import add, cross, dot, norm, scale, subtract
from stability.model import BodyId, Vec3
from stability.problem import Forces, Motion, Problem, Tolerances, admit_problem, rounded
from stability.process_settings import one_thread
from stability.statics.certificate import lies_on
from stability.statics.conic_program import ConicProgram, clarabel_solve, solve
from stability.statics.equilibrium import proven_inside, separating_motion
from stability.statics.load_factor import central_forces
from stability.statics.proof import check_forces, motion_plus, power, proof_cones, shortfalls
from stability.statics.wrench_matrix import WrenchMatrix, wrench_matrix
from stability.strength import Strength, admit_strengths

ACCURACIES = (1e-10, 1e-8)  # requested of the solver, tried in turn; its points are checked
MOST_ROUNDS = 30  # of cutting triangles
MOST_LINES = 8  # borders of the crushed area, of the last motions, along which the triangles are cut
CLOSE = 1e-7  # share: bounds of the used strength that are as near to each other are not refined
TOLD = 1e-4  # share by which they may differ where something crushes, and only that is asked
EXACT = 1e-6  # a strength that is used up to this share more counts as not exceeded
ALIKE = 1e-4  # share of the power of crushing by which bricks that give way alike may differ
THIN = 1e-9  # share of an edge: a cut nearer to a corner changes nothing
CORNERS_OF_A_FACE = 3
ROUNDING = 1e-12  # share of the fastest speed by which contacts open beyond what a proof requires

Triangle = tuple[Vec3, Vec3, Vec3]


@dataclass(frozen=True, slots=True)
class UsedStrength:
    """Least factor on all strengths with which a structure stands, with a proof on both sides."""

    least: float  # proven by `motion`; 0 if there is none
    enough: float  # proven by forces; inf if there are none
    motion: Motion | None
    brick: BodyId = ""  # that takes most of the power of this motion
    shares: Mapping[BodyId, float] = field(default_factory=dict)  # of its strength, by brick, that these forces use

    def within(self, share: float) -> bool:
        """Return whether both bounds differ by a share at most."""
        return self.enough < inf and self.enough - self.least <= share * self.enough

    @property
    def bears(self) -> bool:
        """Return whether the bricks are proven to bear all forces that balance them."""
        return self.enough <= 1.0 + EXACT

    @property
    def crushes(self) -> bool:
        """Return whether no forces that the bricks bear balance them."""
        return self.least > 1.0 + EXACT


@dataclass(frozen=True, slots=True)
class _Cell:
    """Part of a contact under a bounded pressure."""

    contact: int
    corners: Triangle
    most: float  # greatest force [N]
    brick: BodyId  # whose strength it is

    @property
    def centre(self) -> Vec3:
        a, b, c = self.corners
        return scale(1.0 / 3.0, add(add(a, b), c))

    def cut(self, depth: Sequence[float]) -> Iterator["_Cell"]:
        """Yield the parts on either side of the line where a linear function of the corners vanishes."""
        for alone in range(3):
            one, other = (alone + 1) % 3, (alone + 2) % 3
            if depth[alone] * depth[one] < 0.0 and depth[alone] * depth[other] <= 0.0:
                shares = [depth[alone] / (depth[alone] - depth[far]) if depth[far] else 1.0 for far in (one, other)]
                if max(shares) < THIN or min(shares) > 1.0 - THIN:
                    break
                tip = self.corners[alone]
                left, right = (
                    between(tip, self.corners[far], share) for far, share in zip((one, other), shares, strict=True)
                )
                area = area_of(self.corners)
                pressure = self.most / area
                parts = (
                    (tip, left, right),
                    (left, self.corners[one], self.corners[other]),
                    (left, self.corners[other], right),
                )
                for part in parts:
                    if area_of(part) > THIN * THIN * area:
                        yield replace(self, corners=part, most=pressure * area_of(part))
                return
        yield self


def area_of(triangle: Triangle) -> float:
    """Return the area of a triangle [m2]."""
    a, b, c = triangle
    return 0.5 * norm(cross(subtract(b, a), subtract(c, a)))


@one_thread()
def used_strength(
    problem: Problem,
    strengths: Mapping[BodyId, Strength],
    tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
    *,
    decide: bool = False,
) -> UsedStrength:
    """Return the share of their strength that the bricks of a problem use, which stands if nothing crushes.

    Both bounds differ by a share of 1e-6 or less, where the solver's accuracy suffices; with `decide` only by as much
    as needed to tell whether something crushes, and by how much. Raises OtherLawError for bricks with joints or round
    contacts.
    """
    admit_problem(problem)
    admit_strengths(strengths)
    if problem.has_joints:
        raise OtherLawError("a crushing strength is not supported for bricks with joints")
    if problem.is_round:
        raise OtherLawError("a crushing strength is not supported for bricks with round contacts")
    tolerances = rounded(problem, tolerances)
    cells = list(_cells(problem, strengths))
    stacks = {name: each.stack for name, each in sorted(strengths.items()) if each.stack < inf}
    stacks = {
        name: most for name, most in stacks.items() if any(c.lower == name and lies_on(c) for c in problem.contacts)
    }
    best = UsedStrength(0.0, inf, None)
    if not (cells or stacks):
        return UsedStrength(0.0, 0.0, None)
    search = _Search(problem, stacks, separating_motion(problem), tolerances)
    whole, lines = cells, list[_Crushing]()
    for _ in range(MOST_ROUNDS):
        best, last = search.improved(best, cells)
        told = decide and (best.bears or (best.crushes and best.within(TOLD)))
        if told or last is None or not cells or best.within(CLOSE):
            break
        lines = [*lines[1 - MOST_LINES :], last]
        cells = whole
        for line in lines:
            depths = search.depths(cells, line)
            cells = [part for cell, depth in zip(cells, depths, strict=True) for part in cell.cut(depth)]
    return best


def bear(problem: Problem, forces: Forces, strengths: Mapping[BodyId, Strength], tolerances: Tolerances) -> bool:
    """Return whether forces balance a problem and load no brick beyond its strength; False if pressures are bounded."""
    if any(each.pressure < inf for each in strengths.values()):
        return False
    carried: dict[BodyId, float] = {}
    for contact, of in zip(problem.contacts, forces.of_contacts, strict=True):
        if lies_on(contact):
            pressing = sum(dot(force, n) for point in of for force, n in zip(point, contact.normals_W, strict=True))
            carried[contact.lower] = carried.get(contact.lower, 0.0) + pressing
    if any(carried.get(name, 0.0) > each.stack for name, each in strengths.items()):
        return False
    return check_forces(problem, forces, rounded(problem, tolerances)).holds


def _cells(problem: Problem, strengths: Mapping[BodyId, Strength]) -> Iterator[_Cell]:
    """Yield the triangles of all faces in contact under a bounded pressure, by contact."""
    none = Strength()
    for number, contact in enumerate(problem.contacts):
        brick = min((contact.lower, contact.upper), key=lambda name: (strengths.get(name, none).pressure, name))
        pressure = strengths.get(brick, none).pressure
        corners = contact.points_W
        if pressure == inf or len(corners) < CORNERS_OF_A_FACE or len(contact.normals_W) != 1:
            continue
        x, y, z = (sum(each) / len(corners) for each in zip(*corners, strict=True))
        for one, other in zip(corners, (*corners[1:], corners[0]), strict=True):
            triangle = ((x, y, z), one, other)
            if area_of(triangle) > 0.0:
                yield _Cell(number, triangle, pressure * area_of(triangle), brick)


@dataclass(frozen=True, slots=True)
class _Crushing:
    """Motion at which bricks give way."""

    motion: Motion
    gives: Mapping[BodyId, float]  # speed at which the stack load of a brick gives way [m/s]


@dataclass(frozen=True, slots=True)
class _Search:
    """Problem whose used strength is computed."""

    problem: Problem
    stacks: Mapping[BodyId, float]
    separating: Motion | None
    tolerances: Tolerances

    def improved(self, best: UsedStrength, cells: Sequence[_Cell]) -> tuple[UsedStrength, _Crushing | None]:
        """Return the better of earlier bounds and those with these cells, and the motion of the latter."""
        last = None
        for accuracy in ACCURACIES:
            found, last = self.bounds(cells, accuracy)
            if found.least > best.least:
                best = replace(best, least=found.least, motion=found.motion, brick=found.brick)
            if found.enough < best.enough:
                best = replace(best, enough=found.enough, shares=found.shares)
            if last is not None:
                break
        return best, last

    def bounds(self, cells: Sequence[_Cell], accuracy: float) -> tuple[UsedStrength, _Crushing | None]:
        """Return what forces at the centres of the cells prove, what their motion proves, and this motion."""
        at_centres = self._with_points(cells, lambda cell: (cell.centre,))
        system = wrench_matrix(at_centres)
        groups, most = self._groups(at_centres, cells)
        unit = sum(norm(load.force_W) for load in self.problem.loads.values()) or 1.0
        point = solve(_program(system, groups, most / unit, unit), accuracy, clarabel_solve)
        if isinstance(point, str) or not (np.isfinite(point.x).all() and np.isfinite(point.dual).all()):
            return UsedStrength(0.0, inf, None), None
        rows = point.dual[1 : 1 + len(system.rows)]
        # A solver is as accurate as the largest forces need, which is too little for those of thin triangles.
        nearly = _sums(at_centres, groups, system.forces(system.project(rows)), len(most))[: len(cells)]
        most_nearly = float(system.loads @ point.x[: len(system.loads)]) * most[: len(cells)]
        places = _normal_rows_of(system)[groups[0][: len(cells)]]
        rows[places] *= np.where(nearly > most_nearly, most_nearly / np.maximum(nearly, most_nearly), 1.0)
        forces = self._balanced(at_centres, system, rows)
        used = np.full(len(most), inf) if forces is None else _sums(at_centres, groups, forces, len(most)) / most
        enough, shares = float(used.max(initial=0.0)), dict[BodyId, float]()
        for name, part in zip([*(cell.brick for cell in cells), *self.stacks], used.tolist(), strict=True):
            shares[name] = max(part, shares.get(name, 0.0))
        columns = len(system.loads)
        rates = np.maximum(point.x[columns + len(cells) :], 0.0) / unit
        gives = dict(zip(self.stacks, rates.tolist(), strict=True))
        crushing = self._free(cells, _Crushing(system.unscaled_motion(point.x[:columns]), gives))
        if crushing is None:
            return UsedStrength(0.0, enough, None, shares=shares), None
        powers = {name: self.stacks[name] * rate for name, rate in gives.items()}
        for cell, depth in zip(cells, self.depths(cells, crushing), strict=True):
            # A closing speed is convex, so its mean over a triangle is at most that at the corners.
            taken = cell.most * sum(max(each, 0.0) for each in depth) / 3.0
            powers[cell.brick] = powers.get(cell.brick, 0.0) + taken
        total = sum(powers.values())
        least = max(0.0, power(self.problem.loads, crushing.motion) / total) if total > 0.0 else 0.0
        # Of bricks that give way alike, the first is named, whatever the rounding.
        most_power = (1.0 - ALIKE) * max(powers.values())
        first = min(name for name, taken in powers.items() if taken >= most_power)
        return UsedStrength(least, enough, crushing.motion, first, shares), crushing

    def _balanced(self, problem: Problem, system: WrenchMatrix, rows: Array) -> Forces | None:
        """Return forces near the given ones that are proven to balance the problem; None if none are found."""

        def central() -> Array | None:
            middle = central_forces(system, system.loads, min(ACCURACIES), clarabel_solve)
            return None if isinstance(middle, str) else middle

        return proven_inside(problem, system, rows, central, self.tolerances)

    def depths(self, cells: Sequence[_Cell], crushing: _Crushing) -> list[list[float]]:
        """Return the closing speed at each corner of each cell [m/s]; negative where the contact opens."""
        at_corners = self._with_points(cells, lambda cell: cell.corners)
        short = self._closing(at_corners, crushing)
        starts = _starts(at_corners)
        seen: dict[int, int] = {}
        found = []
        for cell in cells:
            first = int(starts[cell.contact]) + 3 * seen.get(cell.contact, 0)
            seen[cell.contact] = seen.get(cell.contact, 0) + 1
            found.append(short[first : first + 3].tolist())
        return found

    def _free(self, cells: Sequence[_Cell], crushing: _Crushing) -> _Crushing | None:
        """Return a motion near the given one that no contact stops whose force is unbounded; None if none is found."""
        free = {cell.contact for cell in cells}
        others = replace(self.problem, contacts=[c for i, c in enumerate(self.problem.contacts) if i not in free])
        short = self._closing(others, crushing)
        if not (short > 0.0).any():
            return crushing
        cones = proof_cones(others)
        if self.separating is None or cones is None:
            return None
        spare = -shortfalls(cones, np.zeros(len(short)), self.separating)
        fastest = max(abs(part) for velocity, _ in crushing.motion.velocity.values() for part in velocity)
        rate = float(((short + ROUNDING * fastest) / spare).max())
        moved = replace(crushing, motion=motion_plus(crushing.motion, rate, self.separating))
        return None if (self._closing(others, moved) > 0.0).any() else moved

    def _closing(self, problem: Problem, crushing: _Crushing) -> Array:
        """Return by force how much faster a contact closes than its stack gives way [m/s]."""
        cones = proof_cones(problem)
        sizes = np.diff(_starts(problem))
        if cones is None:
            return np.full(int(sizes.sum()), inf)
        gives = [crushing.gives.get(each.lower, 0.0) if lies_on(each) else 0.0 for each in problem.contacts]
        return shortfalls(cones, -np.repeat(gives, sizes), crushing.motion)

    def _with_points(self, cells: Sequence[_Cell], points: Callable[[_Cell], Sequence[Vec3]]) -> Problem:
        """Return the problem with other points of contacts that have cells."""
        of_contact: dict[int, list[Vec3]] = {}
        for cell in cells:
            of_contact.setdefault(cell.contact, []).extend(points(cell))
        contacts = [
            replace(contact, points_W=tuple(of_contact[number]), gaps=()) if number in of_contact else contact
            for number, contact in enumerate(self.problem.contacts)
        ]
        return replace(self.problem, contacts=contacts)

    def _groups(self, at_centres: Problem, cells: Sequence[_Cell]) -> tuple[tuple[Indices, Indices], Array]:
        """Return groups of forces whose sum is bounded, as pairs of force and group, and the bounds [N]."""
        starts = _starts(at_centres)
        seen: dict[int, int] = {}
        forces, group = [], []
        for number, cell in enumerate(cells):
            place = seen[cell.contact] = seen.get(cell.contact, -1) + 1
            forces.append(int(starts[cell.contact]) + place)
            group.append(number)
        for number, name in enumerate(self.stacks, start=len(cells)):
            for contact in (i for i, c in enumerate(self.problem.contacts) if c.lower == name and lies_on(c)):
                own = range(int(starts[contact]), int(starts[contact + 1]))
                forces += own
                group += [number] * len(own)
        bounds = np.array([*(cell.most for cell in cells), *self.stacks.values()])
        return (np.array(forces, dtype=np.int64), np.array(group, dtype=np.int64)), bounds


def _starts(problem: Problem) -> Indices:
    """Return the number of the first force of each contact, and the number of all forces."""
    starts: Indices = np.cumsum([0, *(len(c.points_W) * len(c.normals_W) for c in problem.contacts)], dtype=np.int64)
    return starts


def _program(system: WrenchMatrix, groups: tuple[Indices, Indices], most: Array, unit: float) -> ConicProgram:
    """Return the program of the largest power of the loads at a power of crushing of one."""
    from scipy.sparse import bmat, csr_matrix, identity  # noqa: PLC0415 -- slow to import, seldom needed

    rows, count = system.rows, len(most)
    places = _normal_rows_of(system)[groups[0]]
    crush = csr_matrix((system.row_scale[places] / unit, (places, groups[1])), shape=(len(rows), count))
    one = csr_matrix(most[None, :])
    matrix = bmat([[None, one], [-system.matrix, -crush], [None, -identity(count)]], format="csc")
    offset = np.concatenate([[1.0], np.zeros(len(rows) + count)])
    cost = np.append(-system.loads, np.zeros(count))
    return rows.program(cost, matrix, offset, equal=1, positive=count)


def _normal_rows_of(system: WrenchMatrix) -> Indices:
    """Return the row of each normal force."""
    order = np.append(system.round, system.flat)
    row_of = np.empty(len(order), dtype=np.int64)
    row_of[order] = system.rows.normals
    return row_of


def _sums(problem: Problem, groups: tuple[Indices, Indices], forces: Forces, count: int) -> Array:
    """Return by group the sum of its normal forces [N]."""
    normal = np.array(
        [
            sum(f * n for f, n in zip(force_W, normal_W, strict=True))
            for contact, by_point in zip(problem.contacts, forces.of_contacts, strict=True)
            for by_normal in by_point
            for force_W, normal_W in zip(by_normal, contact.normals_W, strict=True)
        ]
    )
    sums: Array = np.bincount(groups[1], normal[groups[0]], minlength=count).astype(float)
    return sums
