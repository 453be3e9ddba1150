"""Finds the largest placement error that all bricks may have at once before a verdict changes."""

from collections import defaultdict
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from math import atan2, degrees, hypot, inf, radians
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stability.analysis.mirrored_program import Block, Parts, folded
from stability.contact_law import Coulomb, coulomb_coefficients
from stability.geometry.polygons import Point2, Polygon, hull, inset
from stability.geometry.rows import Array, Indices
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
LARGE = 100  # bricks: the program of a larger structure is folded along its mirrors
AT_ONCE = 16  # bricks whose displacements are answered at once, which limits memory
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
    solve: Callable[[Array], Array]  # of `balance @ balance.T`, whose inverse gives the rule
    by_moments: Array  # (3 bricks, 2 bricks) columns of this inverse: for both moments on each brick
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
                block = _block(problem, patch, body, unit[k], (sign * force[i], length[i]))
                balance.put(3 * i, 3 * k, block)
                if patch.moving:
                    on_plane.put(i, 3 * k, [block[0][:1]])
    columns = 3 * len(patches)
    rows = balance.matrix(3 * len(names), columns)
    answers = _solved(rows)
    if answers is None:
        return None
    of_planes = on_plane.matrix(len(names), columns)
    planar = np.diff(of_planes.indptr) > 0
    loads = _loads(problem, names, force, length)
    return Recourse(names, patches, force, length, unit, rows, loads, *answers, planar, of_planes[planar])


class _Entries:
    """Sparse matrix of dense blocks of one shape: a brick touches few others, so nearly all entries are zero."""

    def __init__(self) -> None:
        self._rows: list[int] = []
        self._columns: list[int] = []
        self._blocks: list[Sequence[Sequence[float]]] = []

    def put(self, row: int, column: int, block: Sequence[Sequence[float]]) -> None:
        """Add a block with its first row and column."""
        self._rows.append(row)
        self._columns.append(column)
        self._blocks.append(block)

    def matrix(self, rows: int, columns: int) -> Sparse:
        """Return the matrix of all blocks, by row."""
        from scipy.sparse import csr_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

        if not self._blocks:
            return csr_matrix((rows, columns))
        return _of_blocks(np.array(self._rows), np.array(self._columns), np.array(self._blocks), (rows, columns))


def _of_blocks(rows: Indices, columns: Indices, blocks: Array, shape: tuple[int, int]) -> Sparse:
    """Return the sparse matrix, by row, of dense blocks with their first rows and columns."""
    from scipy.sparse import csr_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    down, along = np.indices(blocks.shape[1:])
    places = (rows[:, None, None] + down).ravel(), (columns[:, None, None] + along).ravel()
    return csr_matrix((blocks.ravel(), places), shape=shape)


def _units(patch: PlanPatch, number: dict[BodyId, int], force: Array) -> tuple[float, float]:
    held = patch.upper if patch.upper in number else patch.lower
    return force[number[held]], patch.reach


def _block(
    problem: Problem, patch: PlanPatch, body: BodyId, unit: Array, scale: tuple[float, float]
) -> list[list[float]]:
    """Return scaled vertical force and first moments about a brick's centre from those of a patch about its centre."""
    x, y, _ = problem.bricks[body].pose.position_W
    (px, py), arm = patch.centre, scale[1]
    lever, force = unit[1] / arm, unit[0] / scale[0]
    return [
        [force, 0.0, 0.0],
        [force * (px - x) / arm, force * lever, 0.0],
        [force * (py - y) / arm, 0.0, force * lever],
    ]


def _loads(problem: Problem, names: Sequence[BodyId], force: Array, length: Array) -> Array:
    """Return (bricks, 3) vertical loads and their first moments, scaled."""
    wrenches = [problem.loads.get(name, Wrench(ZERO)) for name in names]
    loads = np.array([(w.force_W[2], -w.torque_W[1], w.torque_W[0]) for w in wrenches], dtype=float).reshape(-1, 3)
    loads /= np.stack([force, force * length, force * length], axis=1)
    return loads


def _solved(balance: Sparse) -> tuple[Callable[[Array], Array], Array] | None:
    """Return the solver of the squared balance, and the columns of its inverse; None if a row cannot be balanced."""
    from scipy.sparse.linalg import splu  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    squared = (balance @ balance.T).tocsc()
    rows = len(squared.indptr) - 1
    try:
        factors = splu(squared)
    except RuntimeError:  # the matrix is singular
        return None

    def solve(wanted: Array) -> Array:
        solution = factors.solve(wanted)
        refined: Array = solution + factors.solve(wanted - squared @ solution)  # one step of iterative refinement
        return refined

    by_moments = np.empty((rows, rows // 3 * 2))
    for first in range(0, rows, 3 * AT_ONCE):
        columns = np.arange(first, min(first + 3 * AT_ONCE, rows))
        each = np.zeros((rows, len(columns)))
        each[columns, columns - first] = 1.0
        inverse = solve(each)
        if not np.abs(squared @ inverse - each).max(initial=0.0) < BALANCED:
            return None
        by_moments[:, first // 3 * 2 : columns[-1] // 3 * 2 + 2] = inverse[:, columns % 3 > 0]
    return solve, by_moments


@dataclass(frozen=True, slots=True, eq=False)
class _Edges:
    """Inset borders of all patches as linear functions that must not be negative."""

    patch: NDArray[np.int64]  # (edges,)
    rows: Sparse  # (edges, 3 patches) slack of a patch's force at a border line
    of_loads: Array  # (edges,) decrease of the slack by displaced loads, per unit of displacement
    # (edges, planar bricks) decrease by displaced forces of planes, per unit of displacement and force
    of_planes: Array


def _edges(rule: Recourse, error: float) -> _Edges:
    from scipy.sparse import csr_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    patch = np.repeat(np.arange(len(rule.patches)), [len(p.depth) for p in rule.patches])
    fixed = np.array([0.0 if p.moving else error for p in rule.patches])[patch]
    depth = (np.concatenate([p.depth for p in rule.patches] or [np.zeros(0)]) - fixed) / rule.unit[patch, 1]
    entries = np.column_stack([depth, np.concatenate([p.inward for p in rule.patches] or [np.zeros((0, 2))])])
    of_columns = 3 * patch[:, None] + np.arange(3)
    starts = 3 * np.arange(len(patch) + 1)
    rows = csr_matrix((entries.ravel(), of_columns.ravel(), starts), shape=(len(patch), 3 * len(rule.patches)))
    return _Edges(patch, rows, *_effects(rule, rows))


def _effects(rule: Recourse, rows: Sparse) -> tuple[Array, Array]:
    """Return the largest changes of rows of patch forces if loads move by 1 m in plan.

    The first result (rows,) is for the loads of all bricks that are not on a plane together; the second (rows, planar
    bricks) is for a unit force on each of the others.
    """
    through, bricks = rows @ rule.balance.T, len(rule.names)
    of_loads, of_each = np.zeros(rows.shape[0]), np.zeros((rows.shape[0], bricks - int(np.sum(~rule.planar))))
    weights, place = np.where(rule.planar, 0.0, np.abs(rule.loads[:, 0])), np.cumsum(rule.planar) - 1
    for first in range(0, bricks, AT_ONCE):
        some = np.arange(first, min(first + AT_ONCE, bricks))
        moments = through @ rule.by_moments[:, 2 * first : 2 * some[-1] + 2]
        lengths = np.hypot(moments[:, 0::2], moments[:, 1::2]) / rule.length[some]
        of_loads += lengths @ weights[some]
        on_planes = rule.planar[some]
        of_each[:, place[some[on_planes]]] = lengths[:, on_planes]
    return of_loads, of_each


@dataclass(frozen=True, slots=True, eq=False)
class _Frictional:
    """Forces at the corners of inset patches: z, x and y each.

    They lie within their cones and do not depend on the displacements.
    """

    law: Coulomb  # of all corners
    rows: ConeRows  # limits of the vertical forces by friction, then the horizontal forces
    upright: Sparse  # (3 bricks, 3 corners) vertical force and first moments on the bricks
    sideways: Sparse  # (3 bricks, 3 corners) horizontal force and twist
    corners_W: Array  # (corners, 3) [m]
    patch: NDArray[np.int64]  # (corners,)


def _frictional(rule: Recourse, problem: Problem, error: float) -> _Frictional:
    number = {name: i for i, name in enumerate(rule.names)}
    places = np.array([problem.bricks[name].pose.position_W for name in rule.names])
    corners = [
        (k, x, y, p.height)
        for k, p in enumerate(rule.patches)
        if p.level and p.friction > 0.0
        for x, y in inset(p.corners, error)
    ]
    points = np.array([point for _, *point in corners]).reshape(-1, 3)
    of_patch = np.array([k for k, *_ in corners], dtype=np.int64)
    rows, columns, upright, sideways = [], [], [], []
    for bodies, sign in (([p.upper for p in rule.patches], 1.0), ([p.lower for p in rule.patches], -1.0)):
        brick = np.array([number.get(body, -1) for body in bodies], dtype=np.int64)[of_patch]
        column = np.flatnonzero(brick >= 0)
        brick = brick[column]
        scale = sign * rule.unit[of_patch[column], 0] / rule.force[brick]
        x, y, z = scale / rule.length[brick] * (points[column] - places[brick]).T
        zero = np.zeros(len(column))
        upright.append(np.array([[scale, zero, zero], [x, -z, zero], [y, zero, -z]]).transpose(2, 0, 1))
        sideways.append(np.array([[zero, scale, zero], [zero, zero, scale], [zero, -y, x]]).transpose(2, 0, 1))
        rows.append(3 * brick)
        columns.append(3 * column)
    law, cones = Coulomb(np.array([rule.patches[k].friction for k in of_patch])), ConeRows(len(corners), 0)
    up, aside = (
        _of_blocks(
            np.concatenate(rows), np.concatenate(columns), np.concatenate(blocks), (3 * len(rule.names), len(cones))
        )
        for blocks in (upright, sideways)
    )
    return _Frictional(law, cones, up, aside, points, of_patch)


def displaced(rule: Recourse, problem: Problem, error: float) -> PlacementAnswer:
    """Return the largest common displacement of all loads that is survived with patches inset by `error`.

    The unknowns are the patch forces, the frictional forces, for each brick on a plane a bound on its load, and
    the displacement. The load of a brick on a plane replaces its weight, but depends on the result itself: a bound that
    holds for its own consequences holds (the result is a fixed point within the bound).
    """
    from scipy.sparse import block_array, csc_matrix, diags  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    edges, frictional = _edges(rule, error), _frictional(rule, problem, error)
    planar, on_plane = rule.planar, rule.on_plane
    of_loads, of_planes = _effects(rule, on_plane)
    by_loads, by_planes = of_loads[:, None], error * of_planes - np.eye(on_plane.shape[0])
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
    smaller = folded(program, *_blocks(rule, problem, edges, frictional)) if len(rule.names) >= LARGE else None
    x = clarabel_solve(program, ACCURACY).x if smaller is None else smaller.whole(ACCURACY)
    return _judged(rule, edges, frictional, error, x)


def _blocks(
    rule: Recourse, problem: Problem, edges: _Edges, frictional: _Frictional
) -> tuple[Sequence[Block], Sequence[Block]]:
    """Return the rows and the columns of the program, by what they belong to."""
    places = np.array([problem.bricks[name].pose.position_W for name in rule.names])
    middle = 0.5 * (places.min(axis=0) + places.max(axis=0))[:2]
    moments = rule.loads[:, 1:] * rule.length[:, None]
    bricks = Parts(
        np.hstack([places[:, :2] - middle, moments]),
        np.column_stack([places[:, 2], rule.loads[:, 0], rule.force, rule.length]),
    )
    centres = np.array([patch.centre for patch in rule.patches]) - middle
    kinds = np.array([(patch.height, patch.friction, patch.moving, patch.level) for patch in rule.patches])
    patches = Parts(centres, np.hstack([kinds, rule.unit]))
    inward = np.concatenate([patch.inward for patch in rule.patches])
    borders = Parts(np.hstack([centres[edges.patch], inward]), kinds[edges.patch, :1])
    corners = Parts(
        np.hstack([frictional.corners_W[:, :2] - middle, centres[frictional.patch]]), frictional.corners_W[:, 2:]
    )
    planar = Parts(bricks.vectors[rule.planar], bricks.scalars[rule.planar])
    alone = Parts(np.zeros((1, 2)), np.zeros((1, 1)))
    in_plan, along = ((False, False), (True, False), (False, True)), ((True, False), (False, True), (True, True))
    same = ((False, False),)
    rows = [(bricks, in_plan), (bricks, along), (corners, in_plan), (borders, same), (planar, same), (planar, same)]
    return [*rows, (alone, same)], [(patches, in_plan), (corners, in_plan), (planar, same), (alone, same)]


def _judged(rule: Recourse, edges: _Edges, frictional: _Frictional, error: float, x: Array) -> PlacementAnswer:
    """Check a solution by plain arithmetic: whether it survives `error`, and the error up to which it does."""
    count = 3 * len(rule.patches)
    forces = _inside(frictional, x[count : count + len(frictional.rows)])
    left = rule.balance @ x[:count] + frictional.upright @ forces + rule.loads.ravel()
    patches = x[:count] - rule.balance.T @ rule.solve(left)
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
        of_loads, of_planes = _effects(rule, on_plane)
        still = np.abs(on_plane @ patches + rule.loads[planar, 0]) + error * of_loads
        feedback = error * of_planes
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
    rules: dict[tuple[int, ...], Recourse | None] = {}

    def answer(error: float) -> PlacementAnswer | None:
        """Return the result for the patches that remain with every brick displaced by `error`."""
        left = tuple(k for k, patch in enumerate(patches) if patch.moving or inset(patch.corners, error))
        if left not in rules:
            rules.clear()  # one of a large wall takes over a hundred megabytes
            rules[left] = recourse(problem, [patches[k] for k in left])
        rule = rules[left]
        return None if rule is None else displaced(rule, problem, error)

    whole = answer(0.0)
    widest = max((patch.reach for patch in patches if not patch.moving), default=1.0)
    if whole is None or not whole.displacement > -BALANCED * widest:  # also catches NaN
        return PlacementMargin(0.0, reason=UNSAFE)
    if whole.displacement == inf and _survives(answer(widest)):
        return PlacementMargin(inf)
    value, limits = _crossing(answer, whole, min(whole.displacement, widest), tolerance)
    if value > BALANCED * widest:
        return PlacementMargin(value, limits)
    # The rest is rounding. A larger error, which is not survived, shows where the load gets beyond a border.
    beyond = answer(NOTICED * widest)
    return PlacementMargin(0.0, () if beyond is None else beyond.limits, UNSAFE)


UNSAFE = "the structure depends on contacts at edges, corners or inclined faces, or has no reserve"


def _pushed_sideways(problem: Problem) -> bool:
    forces = [load.force_W for load in problem.loads.values()]
    return any(max(abs(x), abs(y)) > SIDEWAYS * abs(z) for x, y, z in forces)


def _survives(answer: PlacementAnswer | None) -> bool:
    return answer is not None and answer.survives


def _crossing(
    answer_at: Callable[[float], PlacementAnswer | None], whole: PlacementAnswer, most: float, tolerance: float
) -> tuple[float, tuple[PlacementLimit, ...]]:
    """Return the largest survived error and its limiting contacts: loads survive a displacement of exactly it.

    That displacement decreases with the error, mostly linearly: hence the secant method, with bisection where it fails.
    """
    low, high, limits = 0.0, most, whole.limits
    over = (min(whole.displacement, 2.0 * most), -inf)  # displacement minus error, at `low` and `high`
    error = 0.5 * most
    for step in range(MOST_STEPS):
        answer = answer_at(error)
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
