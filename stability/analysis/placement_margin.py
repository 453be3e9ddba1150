"""Finds the largest placement error that all bricks may have at once before a verdict changes."""

from collections import defaultdict
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from math import atan2, degrees, hypot, inf, radians
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stability.contact_law import Coulomb, coulomb_coefficients
from stability.geometry.polygons import Point2, Polygon, hull, inset
from stability.geometry.rows import Array
from stability.model import GROUND, BodyId, Vec3
from stability.name_order import natural_key
from stability.problem import ZERO, Contact, PlacementLimit, Problem, Wrench
from stability.process_settings import one_thread
from stability.statics.cone_rows import ConeRows
from stability.statics.conic_program import clarabel_solve
from stability.statics.wrench_matrix import passed_down

# Contact patches that remain after placement errors of all bricks in plan.
#
# A contact counts if its patch has area in plan and admits vertical forces (its slope is less than its friction); lines
# and single points vanish with the first error. A displaced brick must still rest on all its supports, so the faces on
# which it rests must be parallel: if they are not, only its level faces count.


LEVEL = 1e-6  # largest horizontal part of a unit normal of a level face: a shift of 1 mm lifts a brick by 1 nm


@dataclass(frozen=True, slots=True, eq=False)
class PlanPatch:
    """Contact in plan: its border lines, and the distance by which placement errors move each line inwards."""

    lower: BodyId
    upper: BodyId
    corners: Polygon  # [m]
    height: float  # mean z of the corners [m]
    friction: float
    level: bool
    moving: bool  # on an infinite plane: the patch moves with its brick and loses nothing
    inward: NDArray[np.float64]  # (edges, 2) unit normals of the border lines
    depth: NDArray[np.float64]  # (edges,) distance of `centre` from them [m]

    @property
    def centre(self) -> Point2:
        """Return the mean of the corners."""
        xs, ys = zip(*self.corners, strict=True)
        return (sum(xs) / len(xs), sum(ys) / len(ys))

    @property
    def reach(self) -> float:
        """Return the largest distance of a corner from the centre [m]."""
        x, y = self.centre
        return max(hypot(a - x, b - y) for a, b in self.corners)


def plan_patches(problem: Problem, planes: Collection[BodyId]) -> list[PlanPatch]:
    """Return the contacts that count, ordered by name and place so that results do not depend on the input order."""
    coulomb_coefficients(contact.law for contact in problem.contacts)  # raises for any other law
    steep = _on_unlike_faces(problem)
    patches = []
    for contact in problem.contacts:
        corners = hull((x, y) for x, y, _ in contact.points_W)
        if not corners or not _carries_upright(contact):
            continue
        if not _is_level(contact) and not steep.isdisjoint((contact.lower, contact.upper)):
            continue
        patches.append(_patch(contact, corners, planes))
    return sorted(patches, key=lambda patch: (patch.lower, patch.upper, patch.corners))


def _patch(contact: Contact, corners: Polygon, planes: Collection[BodyId]) -> PlanPatch:
    points = np.array(corners)
    along = np.roll(points, -1, axis=0) - points
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.hypot(along[:, 0], along[:, 1])[:, None]
    depth = ((points.mean(axis=0) - points) * inward).sum(axis=1)
    height = sum(point[2] for point in contact.points_W) / len(contact.points_W)
    return PlanPatch(
        contact.lower,
        contact.upper,
        corners,
        height,
        contact.law.friction,
        _is_level(contact),
        not {contact.lower, contact.upper}.isdisjoint(planes),
        inward,
        depth,
    )


def _carries_upright(contact: Contact) -> bool:
    """Return whether a contact has one normal and a vertical force lies in its cone."""
    (x, y, z), *others = contact.normals_W
    across = hypot(x, y)
    return not others and z > 0.0 and (across <= LEVEL * z or across <= contact.law.greatest_friction(z))


def _is_level(contact: Contact) -> bool:
    x, y, _ = contact.normals_W[0]
    return hypot(x, y) <= LEVEL


def _on_unlike_faces(problem: Problem) -> set[BodyId]:
    """Return the bodies whose load-bearing faces are not parallel."""
    first: dict[BodyId, Vec3] = {}
    unlike: set[BodyId] = set()
    for contact in filter(_carries_upright, problem.contacts):
        normal = contact.normals_W[0]
        for body in (contact.lower, contact.upper):
            known = first.setdefault(body, normal)
            if body in problem.bricks and max(abs(a - b) for a, b in zip(normal, known, strict=True)) > LEVEL:
                unlike.add(body)
    return unlike


# The program of the placement margin: the largest displacement of loads for patches inset by a given error.
#
# All numbers are scaled, forces by load capacities of bricks and lengths by half diagonals, so that size, density and
# gravity do not matter. The rule of recourse and the inequalities are explained in `placement`.


Sparse: TypeAlias = Any  # by row; scipy's matrices have no types

ACCURACY = 1e-11  # requested accuracy of the solver
BALANCED = 1e-9  # accepted residual as a share of the load capacity: rounding
NOTICED = 1e-6  # share of the reach of a contact: an error that stands out from rounding
ALIKE = 1e-5  # share by which a border may have more left than the worst one and still limit equally
DIGITS = 3  # of a bearing in degrees: with more, rounding would tell one direction twice
FURTHEST = 1e3  # half diagonals; loads that can be displaced so far can be displaced without limit


@dataclass(frozen=True, slots=True)
class PlacementAnswer:
    """Displacement that loads survive with patches inset by an error."""

    displacement: float  # of all loads at once [m], by the solver; inf if nothing limits it
    survives: bool  # whether a displacement of loads by the error itself is survived, by plain arithmetic
    limits: tuple[PlacementLimit, ...]  # the contacts that limit equally, by name


@dataclass(frozen=True, slots=True, eq=False)
class Recourse:
    """Patches and their force responses to moments.

    It holds everything that does not depend on the error while no patch vanishes.
    """

    names: Sequence[BodyId]
    patches: Sequence[PlanPatch]
    force: Array  # (bricks,) unit of forces on each brick [N]
    length: Array  # (bricks,) unit of lever arms of each brick [m]
    unit: Array  # (patches, 2) units of the force [N] and of the lever arms [m] of each patch
    balance: Sparse  # (3 bricks, 3 patches) vertical force and first moments on a brick from those of a patch
    loads: Array  # (bricks, 3)
    answer: Array  # (3 patches, 3 bricks): `balance @ answer = -1`
    planar: NDArray[np.bool_]  # (bricks,) which bricks carry patches with them
    on_plane: Sparse  # (planar bricks, 3 patches) vertical force on such a brick from the patches that move with it


def recourse(problem: Problem, patches: Sequence[PlanPatch]) -> Recourse | None:
    """Return the rule of least norm; None if the patches cannot balance every moment on every brick."""
    names = sorted(problem.bricks)
    number = {name: i for i, name in enumerate(names)}
    carried = passed_down(problem)
    heaviest = max(carried.values(), default=0.0) or 1.0
    force = np.array([carried[name] or heaviest for name in names])
    length = np.array([problem.bricks[name].brick.shape.bounding_radius for name in names])
    unit = np.array([_units(patch, number, force) for patch in patches]).reshape(-1, 2)
    balance, on_plane = _Entries(), _Entries()
    for k, patch in enumerate(patches):
        for body, sign in ((patch.upper, 1.0), (patch.lower, -1.0)):
            if body in number:
                i = number[body]
                block = _block(problem, patch, body, unit[k], (force[i], length[i]))
                balance.put(3 * i, 3 * k, sign * block)
                if patch.moving:
                    on_plane.put(i, 3 * k, sign * block[:1, :1])
    columns = 3 * len(patches)
    rows = balance.matrix(3 * len(names), columns)
    answer = _solved(rows)
    if answer is None:
        return None
    of_planes = on_plane.matrix(len(names), columns)
    planar = np.diff(of_planes.indptr) > 0
    loads = _loads(problem, names, force, length)
    return Recourse(names, patches, force, length, unit, rows, loads, answer, planar, of_planes[planar])


class _Entries:
    """Sparse matrix of dense blocks: a brick touches few others, so nearly all entries are zero."""

    def __init__(self) -> None:
        self._blocks: list[tuple[int, int, Array]] = []

    def put(self, row: int, column: int, block: Array) -> None:
        """Add a block with its first row and column."""
        self._blocks.append((row, column, block))

    def matrix(self, rows: int, columns: int) -> Sparse:
        """Return the matrix of all blocks, by row."""
        from scipy.sparse import csr_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

        places = [np.indices(block.shape) for _, _, block in self._blocks]
        of_rows = [row + place[0].ravel() for place, (row, _, _) in zip(places, self._blocks, strict=True)]
        of_columns = [column + place[1].ravel() for place, (_, column, _) in zip(places, self._blocks, strict=True)]
        values = [block.ravel() for _, _, block in self._blocks]
        if not values:
            return csr_matrix((rows, columns))
        entries = np.concatenate(values), (np.concatenate(of_rows), np.concatenate(of_columns))
        return csr_matrix(entries, shape=(rows, columns))


def _units(patch: PlanPatch, number: dict[BodyId, int], force: Array) -> tuple[float, float]:
    held = patch.upper if patch.upper in number else patch.lower
    return force[number[held]], patch.reach


def _block(problem: Problem, patch: PlanPatch, body: BodyId, unit: Array, scale: tuple[float, float]) -> Array:
    """Return scaled vertical force and first moments about a brick's centre from those of a patch about its centre."""
    x, y, _ = problem.bricks[body].pose.position_W
    (px, py), arm = patch.centre, scale[1]
    reach = unit[1] / arm
    rows = [[1.0, 0.0, 0.0], [(px - x) / arm, reach, 0.0], [(py - y) / arm, 0.0, reach]]
    block: Array = np.array(rows) * (unit[0] / scale[0])
    return block


def _loads(problem: Problem, names: Sequence[BodyId], force: Array, length: Array) -> Array:
    """Return (bricks, 3) vertical loads and their first moments, scaled."""
    wrenches = [problem.loads.get(name, Wrench(ZERO)) for name in names]
    loads = np.array([(w.force_W[2], -w.torque_W[1], w.torque_W[0]) for w in wrenches], dtype=float).reshape(-1, 3)
    loads /= np.stack([force, force * length, force * length], axis=1)
    return loads


def _solved(balance: Sparse) -> Array | None:
    """Return minus the pseudo-inverse; None if a row cannot be balanced."""
    from scipy.sparse.linalg import splu  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    squared = (balance @ balance.T).tocsc()
    each = np.eye(len(squared.indptr) - 1)
    try:
        factors = splu(squared)
    except RuntimeError:  # the matrix is singular
        return None
    inverse = factors.solve(each)
    inverse += factors.solve(each - squared @ inverse)  # one step of iterative refinement
    answer: Array = -(balance.T @ inverse)
    return answer if np.abs(balance @ answer + each).max(initial=0.0) < BALANCED else None


@dataclass(frozen=True, slots=True, eq=False)
class _Edges:
    """Inset borders of all patches as linear functions that must not be negative."""

    patch: NDArray[np.int64]  # (edges,)
    rows: Sparse  # (edges, 3 patches) slack of a patch's force at a border line
    of_loads: Array  # (edges,) decrease of the slack by displaced loads, per unit of displacement
    # (edges, planar bricks) decrease by displaced forces of planes, per unit of displacement and force
    of_planes: Array


def _edges(rule: Recourse, error: float) -> _Edges:
    patch = np.concatenate([np.full(len(p.depth), k) for k, p in enumerate(rule.patches)]).astype(np.int64)
    entries, edge = _Entries(), 0
    for k, p in enumerate(rule.patches):
        depth = (p.depth - (0.0 if p.moving else error)) / rule.unit[k, 1]
        entries.put(edge, 3 * k, np.column_stack([depth, p.inward]))
        edge += len(depth)
    rows = entries.matrix(len(patch), 3 * len(rule.patches))
    effects = _lengths(rule, rows @ rule.answer)
    return _Edges(patch, rows, effects[:, ~rule.planar] @ np.abs(rule.loads[~rule.planar, 0]), effects[:, rule.planar])


def _lengths(rule: Recourse, of_moments: Array) -> Array:
    """Return (rows, bricks): the largest change of each row if a unit force on a brick moves by 1 m in plan.

    `of_moments` (rows, 3 bricks) holds the responses of the rows to vertical loads and to moments.
    """
    pairs = of_moments.reshape(len(of_moments), of_moments.shape[1] // 3, 3)[:, :, 1:]
    return np.hypot(pairs[:, :, 0], pairs[:, :, 1]) / rule.length


@dataclass(frozen=True, slots=True, eq=False)
class _Frictional:
    """Forces at the corners of inset patches: z, x and y each.

    They lie within their cones and do not depend on the displacements.
    """

    law: Coulomb  # of all corners
    rows: ConeRows  # limits of the vertical forces by friction, then the horizontal forces
    upright: Sparse  # (3 bricks, 3 corners) vertical force and first moments on the bricks
    sideways: Sparse  # (3 bricks, 3 corners) horizontal force and twist


def _frictional(rule: Recourse, problem: Problem, error: float) -> _Frictional:
    number = {name: i for i, name in enumerate(rule.names)}
    corners = [
        (k, (x, y, p.height))
        for k, p in enumerate(rule.patches)
        if p.level and p.friction > 0.0
        for x, y in inset(p.corners, error)
    ]
    upright, sideways = _Entries(), _Entries()
    for column, (k, point) in enumerate(corners):
        patch = rule.patches[k]
        for body, sign in ((patch.upper, 1.0), (patch.lower, -1.0)):
            if body not in number:
                continue
            i = number[body]
            x, y, z = (a - b for a, b in zip(point, problem.bricks[body].pose.position_W, strict=True))
            arm = rule.length[i]
            scale = sign * rule.unit[k, 0] / rule.force[i]
            up = np.array([[1.0, 0.0, 0.0], [x / arm, -z / arm, 0.0], [y / arm, 0.0, -z / arm]])
            upright.put(3 * i, 3 * column, scale * up)
            along = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -y / arm, x / arm]])
            sideways.put(3 * i, 3 * column, scale * along)
    law, cones = Coulomb(np.array([rule.patches[k].friction for k, _ in corners])), ConeRows(len(corners), 0)
    rows, columns = 3 * len(rule.names), len(cones)
    return _Frictional(law, cones, upright.matrix(rows, columns), sideways.matrix(rows, columns))


def displaced(rule: Recourse, problem: Problem, error: float) -> PlacementAnswer:
    """Return the largest common displacement of all loads that is survived with patches inset by `error`.

    The unknowns are the patch forces, the frictional forces, for each brick on a plane a bound on its load, and
    the displacement. The load of a brick on a plane replaces its weight, but depends on the result itself: a bound that
    holds for its own consequences holds (the result is a fixed point within the bound).
    """
    from scipy.sparse import block_array, csc_matrix, diags  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    edges, frictional = _edges(rule, error), _frictional(rule, problem, error)
    planar, on_plane = rule.planar, rule.on_plane
    carried = _lengths(rule, on_plane @ rule.answer)
    by_loads = (carried[:, ~planar] @ np.abs(rule.loads[~planar, 0]))[:, None]
    by_planes = error * carried[:, planar] - np.eye(on_plane.shape[0])
    unit = rule.length.max()
    scale = np.ones(len(frictional.rows))
    scale[frictional.rows.normals] = frictional.law.greatest_friction(1.0)
    rows = [
        [-rule.balance, -frictional.upright, None, None],
        [None, -frictional.sideways, None, None],
        [None, -diags(scale), None, None],
        [-edges.rows, None, error * edges.of_planes, unit * edges.of_loads[:, None]],
        [on_plane, None, by_planes, unit * by_loads],
        [-on_plane, None, by_planes, unit * by_loads],
        [None, None, None, np.array([[1.0]])],
    ]
    loads = rule.loads[planar, 0]
    offset = [rule.loads.ravel(), np.zeros(3 * len(rule.names) + len(frictional.rows) + len(edges.patch))]
    offset += [-loads, loads, np.array([FURTHEST])]
    columns = 3 * len(rule.patches) + len(frictional.rows) + len(loads) + 1
    cost = np.zeros(columns)
    cost[-1] = -1.0
    program = frictional.rows.program(
        cost,
        csc_matrix(block_array([[None if part is None else csc_matrix(part) for part in row] for row in rows])),
        np.concatenate(offset),
        equal=6 * len(rule.names),
        positive=len(edges.patch) + 2 * len(loads) + 1,
    )
    point = clarabel_solve(program, ACCURACY)
    return _judged(rule, edges, frictional, error, point.x)


def _judged(rule: Recourse, edges: _Edges, frictional: _Frictional, error: float, x: Array) -> PlacementAnswer:
    """Check a solution by plain arithmetic: whether it survives `error`, and the error up to which it does."""
    count = 3 * len(rule.patches)
    forces = _inside(frictional, x[count : count + len(frictional.rows)])
    left = rule.balance @ x[:count] + frictional.upright @ forces + rule.loads.ravel()
    patches = x[:count] + rule.answer @ left
    spare = edges.rows @ patches
    decrease = error * (edges.of_loads + edges.of_planes @ _carried(rule, patches, error))
    limits = _limits(rule, edges, _share(spare, decrease))
    balanced = np.abs(frictional.sideways @ forces).max(initial=0.0) <= BALANCED
    survives = bool(balanced and (spare - decrease >= -BALANCED).all())
    displacement = float(x[-1])
    return PlacementAnswer(
        inf if displacement > 0.5 * FURTHEST else displacement * float(rule.length.max()),
        survives,
        limits,
    )


def _limits(rule: Recourse, edges: _Edges, share: Array) -> tuple[PlacementLimit, ...]:
    """Return the contacts at whose borders the least share of the displacement is left, equal ones included.

    By symmetry several borders limit equally, and rounding would choose one of them.
    """
    least = share.min(initial=inf)
    found = defaultdict[tuple[BodyId, BodyId], set[float]](set)
    outward = -np.concatenate([patch.inward for patch in rule.patches]) if rule.patches else np.zeros((0, 2))
    for edge in np.flatnonzero(share <= least + ALIKE * abs(least)) if least < inf else ():
        patch, (x, y) = rule.patches[edges.patch[edge]], outward[edge]
        found[patch.lower, patch.upper].add(round(degrees(atan2(y, x)), DIGITS) % 360.0)
    ordered = sorted(found, key=lambda pair: (natural_key(pair[1]), natural_key(pair[0])))
    return tuple(PlacementLimit(*pair, tuple(radians(each) for each in sorted(found[pair]))) for pair in ordered)


def _inside(frictional: _Frictional, forces: Array) -> Array:
    """Return the forces, with those outside their cones replaced by the nearest inside.

    The balance shows the residual.
    """
    triples = frictional.rows.triples(forces).copy()
    triples[:, 0] = np.maximum(triples[:, 0], 0.0)
    tangential = np.hypot(triples[:, 1], triples[:, 2])
    most = frictional.law.greatest_friction(triples[:, 0])
    triples[:, 1:] *= np.where(tangential > most, most / np.where(tangential > 0.0, tangential, 1.0), 1.0)[:, None]
    return triples.ravel()


def _share(spare: Array, decrease: Array) -> Array:
    return np.where(decrease > 0.0, spare / np.where(decrease > 0.0, decrease, 1.0), inf)


def _carried(rule: Recourse, patches: Array, error: float) -> Array:
    """Return a bound on the load of each brick on a plane (planar bricks,); infinite if there is none."""
    planar, on_plane = rule.planar, rule.on_plane
    bound = np.zeros(np.count_nonzero(planar))
    if len(bound):
        effect = error * _lengths(rule, on_plane @ rule.answer)
        still = np.abs(on_plane @ patches + rule.loads[planar, 0]) + effect[:, ~planar] @ np.abs(rule.loads[~planar, 0])
        feedback = effect[:, planar]
        bound = np.linalg.solve(np.eye(len(feedback)) - feedback, still)
    return bound if (bound >= 0.0).all() else np.full(len(bound), inf)


# The placement margin: the largest error that all bricks may have at once before a verdict changes.
#
# The margin is guaranteed: an assembly stands if each brick is displaced in plan by at most the margin. It is a lower
# bound, which columns reach exactly. Bricks are rigid, stay on their supports and keep their weight; loads are taken as
# vertical.
#
# Let each brick i be displaced by d_i, |d_i| <= e. Three things change.
#
# 1. Two faces that meet on a patch P, each moved by no more than e, still meet on P inset by e: around a point of the
#   inset patch a disc of radius e lies in both faces, so neither can lose the point. Forces stand on those points,
#   which stay where they are. A plane without end cannot lose a point: a patch on it goes with its brick, not inset.
# 2. The weight w_i acts at a displaced centre: a first moment d_i w_i.
# 3. A force G_i on a patch that goes with brick i is displaced too: d_i G_i. With 2 it makes d_i (w_i + G_i), which is
#   d_i times what the brick carries; a brick alone on the ground may sit anywhere.
#
# A fixed linear rule balances these moments: a change of the vertical patch forces N and of their first moments m about
# the centre of the patch, of least norm relative to the loads of the patches. A vertical patch force is admissible if
# its resultant lies inside the patch: e_j.m + h_j N >= 0 for each border line j (inward normal e_j, h_j from the
# centre). In this form the worst case over all discs of displacements is exactly a sum of lengths:
#
#     e_j.m + (h_j - e) N  >=  e * sum over i of |e_j.M_i + (h_j - e) N_i| w_i  (M_i, N_i: the rule's response to d_i)
#
# which is linear in (N, m) for a given e. Equilibrium may need friction, so forces at the corners of the inset patches,
# within their cones, are added; these do not depend on the displacements. The margin is the error e for which patches
# inset by e survive a displacement of the loads by exactly e.


MOST_STEPS = 60  # halvings end at the tolerance; this limit only prevents endless loops
SIDEWAYS = 1e-9  # share of a load that may act horizontally and still be rounding


@dataclass(frozen=True, slots=True)
class PlacementMargin:
    """Placement error of all bricks at once that is survived."""

    value: float  # [m] guaranteed; 0 if nothing is, inf if no error in plan matters
    limits: tuple[PlacementLimit, ...] = ()  # the contacts that limit it equally, by name
    reason: str = ""  # why the margin is 0


@one_thread()
def placement(problem: Problem, tolerance: float = 1e-7, planes: Collection[BodyId] = (GROUND,)) -> PlacementMargin:
    """Return the placement error in plan that a problem's bricks survive, to a relative `tolerance`.

    `planes` are the infinite fixed bodies; the borders of any other fixed body do not move.
    """
    if _pushed_sideways(problem):
        return PlacementMargin(
            0.0, reason="a load has a horizontal component, but placement margins are computed for weights only"
        )
    patches = plan_patches(problem, planes)
    whole = _answer(problem, patches, 0.0)
    widest = max((patch.reach for patch in patches if not patch.moving), default=1.0)
    if whole is None or not whole.displacement > -BALANCED * widest:  # also catches NaN
        return PlacementMargin(0.0, reason=UNSAFE)
    if whole.displacement == inf and _survives(_answer(problem, patches, widest)):
        return PlacementMargin(inf)
    value, limits = _crossing(problem, patches, whole, min(whole.displacement, widest), tolerance)
    if value > BALANCED * widest:
        return PlacementMargin(value, limits)
    # The rest is rounding. A larger error, which is not survived, shows where the load gets beyond a border.
    beyond = _answer(problem, patches, NOTICED * widest)
    return PlacementMargin(0.0, () if beyond is None else beyond.limits, UNSAFE)


UNSAFE = "the structure depends on contacts at edges, corners or inclined faces, or has no reserve"


def _pushed_sideways(problem: Problem) -> bool:
    forces = [load.force_W for load in problem.loads.values()]
    return any(max(abs(x), abs(y)) > SIDEWAYS * abs(z) for x, y, z in forces)


def _answer(problem: Problem, patches: list[PlanPatch], error: float) -> PlacementAnswer | None:
    """Return the result for the patches that remain with every brick displaced by `error`."""
    rule = recourse(problem, [patch for patch in patches if patch.moving or inset(patch.corners, error)])
    return None if rule is None else displaced(rule, problem, error)


def _survives(answer: PlacementAnswer | None) -> bool:
    return answer is not None and answer.survives


def _crossing(
    problem: Problem, patches: list[PlanPatch], whole: PlacementAnswer, most: float, tolerance: float
) -> tuple[float, tuple[PlacementLimit, ...]]:
    """Return the largest survived error and its limiting contacts: loads survive a displacement of exactly it.

    That displacement decreases with the error, mostly linearly: hence the secant method, with bisection where it fails.
    """
    low, high, limits = 0.0, most, whole.limits
    over = (min(whole.displacement, 2.0 * most), -inf)  # displacement minus error, at `low` and `high`
    error = 0.5 * most
    for step in range(MOST_STEPS):
        answer = _answer(problem, patches, error)
        excess = -inf if answer is None else min(answer.displacement, 2.0 * most) - error
        if answer is not None and answer.survives:
            low, over, limits = error, (excess, over[1]), answer.limits
        else:
            high, over = error, (over[0], min(excess, 0.0))
        if high - low <= tolerance * high or (low == error and excess <= 0.5 * tolerance * error):
            break
        error = _next(low, high, over, step, tolerance)
    return low, limits


def _next(low: float, high: float, over: tuple[float, float], step: int, tolerance: float) -> float:
    """Return the root of the chord, slightly on its safe side; the middle without a chord and at every third step."""
    middle = 0.5 * (low + high)
    if over[1] == -inf or step % 3 == 2:  # noqa: PLR2004 -- chords may converge slowly from one side
        return middle
    crossing = low + (high - low) * over[0] / (over[0] - over[1]) if over[0] > over[1] else middle
    return min(max(crossing * (1.0 - 0.25 * tolerance), low + 0.25 * (tolerance * high)), high)
