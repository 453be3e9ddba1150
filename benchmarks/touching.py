"""Verifies verdicts on random assemblies with gaps by linear programs with their own contacts, independent of statics.

Boxes, boxes with an eccentric mass, and prisms stand on level or tilted planes, on and beside each other and beside
walls, flush or tilted, with gaps from a nanometre to a centimetre. A body touches another at a point if the gap there,
along a normal with the vertical component n, is at most max(|n|, 1/20) times the reach: 2 % of the least thickness of
the thinner body. All candidates are tested one by one: corners over faces, crossing edges, and the ends of the part of
an edge that is near enough.

A verdict is compared with a wide and a narrow set of contacts. In the wide one, features may miss each other by up to
the reach, faces that are parallel except for a tilt within the reach have forces along the normal of either, and
friction pyramids lie around the cones; in the narrow one, none of this holds, and pyramids lie inside.

- STABLE is contradicted if the wide program has no solution.
- A verdict that needs no gap is contradicted if the wide program without the points across gaps has no solution.
- UNSTABLE is contradicted if the narrow program without the points across gaps has a solution.

Run it with `python -m benchmarks.touching`; `--assemblies 5000 --write` keeps the figures.
"""

import random
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from math import atan, cos, pi, sin

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import Progress
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stability.geometry.box import Box, OffCentreBox
from stability.geometry.solid_making import prism
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Placed, Stability, Verdict
from stability.statics.assembly import Assembly

Array = NDArray[np.float64]

REACH = 0.02  # of the least thickness
BESIDE = 0.05  # of the reach, for a horizontal normal
SIDES = 16  # of the friction pyramids
NO_GAP = 1e-6  # of the least thickness: a smaller gap counts as none
SMALL = 1e-12  # [m] rounding of positions
INSIDE = 1e-6  # [m] accepted overlap of two bodies
PARALLEL = 1e-6  # sine of the angle between edges below which they count as parallel
GRAVITY = 9.81
AT_A_WALL, ON_PILLARS = 0.2, 0.25  # shares of the assemblies


@dataclass(frozen=True)
class Solid:
    """Convex body in W: its corners, the unit normals and loops of its faces, and its edges."""

    name: str
    mass: float  # [kg]
    centre: Array  # (3,) of mass [m]
    corners: Array  # (n, 3) [m]
    normals: Array  # (m, 3)
    loops: Sequence[tuple[int, ...]]
    edges: Sequence[tuple[int, int]]

    @cached_property
    def thickness(self) -> float:
        """Return the least distance of parallel planes around it [m]: across a face, or across two edges."""
        lines = self.corners[[b for _, b in self.edges]] - self.corners[[a for a, _ in self.edges]]
        lines /= np.linalg.norm(lines, axis=1)[:, None]
        ways = np.cross(lines[:, None], lines[None]).reshape(-1, 3)
        lengths = np.linalg.norm(ways, axis=1)
        ways = np.vstack([self.normals, ways[lengths > PARALLEL] / lengths[lengths > PARALLEL, None]])
        return float(np.ptp(ways @ self.corners.T, axis=1).min())

    @cached_property
    def ends(self) -> tuple[Array, Array]:
        """Return the start point of each edge, and the vector along it, in W [m]."""
        begins = self.corners[[a for a, _ in self.edges]]
        return begins, self.corners[[b for _, b in self.edges]] - begins


@dataclass(frozen=True)
class Point:
    """Point at which two bodies may exert forces on each other."""

    lower: int | None  # index of a body; None for a fixed one
    upper: int
    at: Array  # [m]
    normal: Array  # unit, towards `upper`
    friction: float
    gap: float  # [m]
    size: float  # the least thickness of the thinner body [m]

    @property
    def is_across_gap(self) -> bool:
        """Return whether the gap at this point is larger than that of a contact."""
        return self.gap > NO_GAP * self.size


def solid(placed: Placed) -> Solid:
    """Return the body of a placed brick."""
    shape, pose = placed.brick.shape, placed.pose
    turn = Rotation.from_quat(pose.orientation)
    corners = turn.apply(np.array(shape.corners)) + np.array(pose.position_W)
    normals = turn.apply(np.array([face.normal for face in shape.faces]))
    loops = [face.corners for face in shape.faces]
    mass, centre = placed.brick.mass, np.array(pose.position_W)
    return Solid(placed.brick.id, mass, centre, corners, normals, loops, list(shape.edges))


# --- contacts ---------------------------------------------------------------------------------------------------------


def bridged(reach: float, normal: Array) -> float:
    """Return the widest gap that counts along a normal [m]."""
    return reach * max(BESIDE, abs(float(normal[2])))


def plane_points(index: int, body: Solid, plane: Plane) -> Iterator[Point]:
    """Yield the contact points of a body with a plane, including the ends of the near parts of its edges."""
    normal, reach = np.array(plane.normal_W), REACH * body.thickness
    limit = bridged(reach, normal)
    heights = (body.corners - np.array(plane.point_W)) @ normal
    if heights.min() < -1.001 * reach:
        return
    for corner, gap in zip(body.corners, heights, strict=True):
        if gap <= limit:
            yield Point(None, index, corner, normal, plane.friction, gap, body.thickness)
    for a, b in body.edges:
        if (heights[a] <= limit) != (heights[b] <= limit):
            part = (limit - heights[a]) / (heights[b] - heights[a])
            at = body.corners[a] + part * (body.corners[b] - body.corners[a])
            yield Point(None, index, at, normal, plane.friction, limit, body.thickness)


def pair_points(i: int, j: int, bodies: Sequence[Solid], friction: float, aside: float) -> Iterator[Point]:
    """Yield the contact points of two bodies.

    `aside` is the distance by which features may miss each other along the surfaces, as a share of the reach.
    """
    a, b = bodies[i], bodies[j]
    size = min(a.thickness, b.thickness)
    reach = REACH * size
    if (a.corners.min(axis=0) > b.corners.max(axis=0) + reach).any():
        return
    if (b.corners.min(axis=0) > a.corners.max(axis=0) + reach).any():
        return
    miss = max(aside * reach, SMALL)
    for one, other, first, second in ((a, b, i, j), (b, a, j, i)):
        # Faces of `one` with corners, and with parts of edges, of `other`.
        for normal, loop in zip(one.normals, one.loops, strict=True):
            origin = one.corners[loop[0]]
            heights = (other.corners - origin) @ normal
            limit = bridged(reach, normal)
            if heights.min() < -1.001 * reach or heights.min() > limit:
                continue
            inwards = _inwards(one.corners[list(loop)], normal)
            facing = [normal, *(-way for way in other.normals if aside and np.linalg.norm(way + normal) <= REACH)]
            low = [(corner, gap) for corner, gap in zip(other.corners, heights, strict=True) if gap <= limit]
            for k, m in other.edges:
                whole = _Part((other.corners[k], other.corners[m]), (heights[k], heights[m]))
                part = _over_face(whole, limit, inwards, miss)
                low += zip(part.ends, part.gaps, strict=True) if part else ()
            yield from (
                Point(first, second, at, way, friction, float(gap), size)
                for at, gap in low
                if all((at - corner) @ side >= -miss - SMALL for corner, side in inwards)
                for way in facing
            )
    yield from (
        Point(i, j, at, normal, friction, gap, size)
        for at, normal, gap in _crossings(a, b, reach, miss)
        if gap <= bridged(reach, normal)
    )


def _inwards(loop: Array, normal: Array) -> list[tuple[Array, Array]]:
    """Return the sides of a face: a corner, and the unit normal into the face."""
    sides = []
    for corner, after in zip(loop, np.roll(loop, -1, axis=0), strict=True):
        way = np.cross(normal, after - corner)
        sides.append((corner, way / np.linalg.norm(way)))
    return sides


@dataclass(frozen=True)
class _Part:
    """Part of an edge: its ends, and their distances from a face [m]."""

    ends: tuple[Array, Array]
    gaps: tuple[float, float]

    def between(self, start: float, end: float) -> "_Part":
        """Return the part between two shares of its length."""
        (p, q), (gap_p, gap_q) = self.ends, self.gaps
        return _Part(
            (p + start * (q - p), p + end * (q - p)),
            (gap_p + start * (gap_q - gap_p), gap_p + end * (gap_q - gap_p)),
        )

    def where(self, values: Sequence[float]) -> "_Part | None":
        """Return the part with positive values of a linear function, given by its values at the ends."""
        at_p, at_q = values
        if at_p < 0.0 and at_q < 0.0:
            return None
        start = at_p / (at_p - at_q) if at_p < 0.0 else 0.0
        end = at_p / (at_p - at_q) if at_q < 0.0 else 1.0
        return self.between(start, end)


def _over_face(part: _Part | None, limit: float, inwards: Sequence[tuple[Array, Array]], miss: float) -> _Part | None:
    """Return the part of an edge that is near enough to a face, and over it."""
    part = part and part.where([limit - gap for gap in part.gaps])
    for corner, way in inwards:
        part = part and part.where([float((end - corner) @ way) + miss for end in part.ends])
    return part


def _crossings(a: Solid, b: Solid, reach: float, miss: float) -> Iterator[tuple[Array, Array, float]]:
    """Yield crossings of edges, normals from a to b and gaps, if a plane along both edges separates the bodies."""
    (p, u), (q, v) = a.ends, b.ends
    normals = np.cross(u[:, None], v[None])
    lengths = np.linalg.norm(normals, axis=2)
    scale = np.linalg.norm(u, axis=1)[:, None] * np.linalg.norm(v, axis=1)[None]
    crossing = lengths > PARALLEL * scale
    normals = np.where(crossing[:, :, None], normals, 1.0) / np.where(crossing, lengths, 1.0)[:, :, None]
    normals *= np.where(normals @ (b.centre - a.centre) < 0.0, -1.0, 1.0)[:, :, None]
    gaps = np.einsum("ijk,ijk->ij", q[None] - p[:, None], normals)
    near = crossing & (np.abs(gaps) <= 1.001 * reach)
    for k, m in zip(*np.nonzero(near), strict=True):
        normal = normals[k, m]
        if ((a.corners - p[k]) @ normal).max() > miss or ((b.corners - q[m]) @ normal).min() < -miss:
            continue
        s, t = np.linalg.lstsq(np.column_stack([u[k], -v[m]]), q[m] - p[k], rcond=None)[0]
        aside_a, aside_b = miss / np.linalg.norm(u[k]), miss / np.linalg.norm(v[m])
        if -aside_a <= s <= 1.0 + aside_a and -aside_b <= t <= 1.0 + aside_b:
            yield p[k] + s * u[k], normal, float(gaps[k, m])


def points(bodies: Sequence[Solid], planes: Sequence[Plane], friction: float, *, wide: bool) -> list[Point]:
    """Return all contacts, with the gaps that the rule bridges."""
    contacts: list[Point] = []
    for index, body in enumerate(bodies):
        for plane in planes:
            contacts += plane_points(index, body, plane)
    for i, j in combinations(range(len(bodies)), 2):
        contacts += pair_points(i, j, bodies, friction, 1.0 if wide else 0.0)
    return _each_once(contacts)


def _each_once(contacts: Sequence[Point]) -> list[Point]:
    """Return points without duplicates, with the least gap of each."""
    least: dict[object, Point] = {}
    for point in sorted(contacts, key=lambda each: each.gap):
        key = point.lower, point.upper, tuple(np.round(point.at, 8)), tuple(np.round(point.normal, 10))
        least.setdefault(key, point)
    return list(least.values())


# --- balance ----------------------------------------------------------------------------------------------------------


def balances(bodies: Sequence[Solid], contacts: Sequence[Point], *, wide: bool) -> bool:
    """Return whether forces at these points carry all weights.

    Friction pyramids are around the cones if `wide`, else inside.
    """
    if not contacts:
        return False
    at = np.array([each.at for each in contacts])
    normals = np.array([each.normal for each in contacts])
    helper = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    one = np.cross(normals, helper)
    one /= np.linalg.norm(one, axis=1)[:, None]
    other = np.cross(normals, one)
    slope = np.array([each.friction for each in contacts]) / (cos(pi / SIDES) if wide else 1.0)
    weight = sum(body.mass for body in bodies) * GRAVITY / len(bodies)
    forces = np.concatenate(
        [
            normals + slope[:, None] * (cos(2.0 * pi * side / SIDES) * one + sin(2.0 * pi * side / SIDES) * other)
            for side in range(SIDES if slope.any() else 1)
        ]
    )
    matrix = np.zeros((6 * len(bodies), len(forces)))
    for end, sign in (("upper", 1.0), ("lower", -1.0)):
        for number, body in enumerate(bodies):
            own = np.array([getattr(each, end) == number for each in contacts])
            places = np.flatnonzero(np.tile(own, len(forces) // len(contacts)))
            arms = (at[places % len(contacts)] - body.centre) / float(np.ptp(body.corners, axis=0).max())
            matrix[6 * number : 6 * number + 3, places] += sign * forces[places].T
            matrix[6 * number + 3 : 6 * number + 6, places] += sign * np.cross(arms, forces[places]).T
    loads = np.zeros(6 * len(bodies))
    loads[2::6] = [body.mass * GRAVITY / weight for body in bodies]
    for method in ("highs", "highs-ds", "highs-ipm"):
        answer = linprog(np.ones(matrix.shape[1]), A_eq=matrix, b_eq=loads, method=method)
        if answer.status in (0, 2):
            return bool(answer.status == 0)
    raise ArithmeticError("the linear programme was not solved")


# --- random assemblies ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scene:
    """One assembly."""

    planes: tuple[Plane, ...]
    friction: float
    bricks: tuple[Placed, ...]


class Maker:
    """Places bodies in the frame of a plane that may be tilted, whose z axis is its normal."""

    def __init__(self, draw: random.Random, *, smooth: bool) -> None:
        """Draw the plane and the friction; if `smooth`, all bodies slide down the plane to the next one."""
        self.draw = draw
        self.friction = 0.0 if smooth else draw.choice([0.0, draw.uniform(0.0, 0.3), draw.uniform(0.2, 1.0)])
        tilt = (
            draw.uniform(0.02, 0.35)
            if smooth
            else draw.choice([0.0, draw.uniform(0.0, 0.35), 0.95 * atan(self.friction)])
        )
        self.frame = Rotation.from_rotvec(tilt * self.level_way()) if tilt else Rotation.identity()
        self.planes = [Plane(GROUND, (0.0, 0.0, 0.0), self.turned((0.0, 0.0, 1.0)), self.friction)]
        self.placed: list[Placed] = []

    def level_way(self) -> Array:
        """Return a random unit vector in the plane."""
        angle = self.draw.uniform(0.0, 2.0 * pi)
        return np.array([cos(angle), sin(angle), 0.0])

    def turned(self, way: Sequence[float] | Array) -> tuple[float, float, float]:
        """Return a vector of the frame in W."""
        x, y, z = self.frame.apply(way)
        return float(x), float(y), float(z)

    def happens(self, share: float) -> bool:
        """Return True with this probability."""
        return self.draw.random() < share

    def gap(self) -> float:
        """Return zero, or a gap from a nanometre to a centimetre [m]."""
        return 0.0 if self.happens(0.4) else 10.0 ** self.draw.uniform(-9.0, -2.0)

    def lean(self) -> Rotation:
        """Return no rotation, or a small one about a horizontal axis."""
        if self.happens(0.65):
            return Rotation.identity()
        return Rotation.from_rotvec(10.0 ** self.draw.uniform(-7.0, -1.5) * self.level_way())

    def brick(self, size: tuple[float, float, float] | None = None) -> Brick:
        """Return a box, one with an eccentric mass, or a prism that tapers upwards."""
        draw = self.draw
        x, y, z = size or (draw.uniform(0.05, 0.4), draw.uniform(0.05, 0.3), draw.uniform(0.01, 0.2))
        name, mass = f"b{len(self.placed)}", 600.0 * x * y * z * 10.0 ** draw.uniform(-0.5, 0.5)
        if self.happens(0.5):
            return Brick(name, Box((x, y, z)), mass)
        if self.happens(0.5):
            off = tuple(draw.uniform(-0.3, 0.3) * side for side in (x, y, z))
            return Brick(name, OffCentreBox((x, y, z), off), mass)  # type: ignore[arg-type]
        left, right = (draw.uniform(0.0, 0.4) * x for _ in range(2))
        outline = [(-0.5 * x, 0.0), (0.5 * x, 0.0), (0.5 * x - right, z), (-0.5 * x + left, z)]
        return Brick(name, prism(outline, y).shape, mass)

    def put(self, brick: Brick, at: Array, turn: Rotation, bottom: float) -> None:
        """Place a body with its middle over a point of the frame and its lowest corner at a height."""
        corners = turn.apply(np.array(brick.shape.corners))
        low, high = corners.min(axis=0), corners.max(axis=0)
        position = np.array([at[0] - 0.5 * (low[0] + high[0]), at[1] - 0.5 * (low[1] + high[1]), bottom - low[2]])
        x, y, z, w = (self.frame * turn).as_quat()
        self.placed.append(Placed(brick, Pose(self.turned(position), (x, y, z, w))))

    def top(self, index: int) -> tuple[Array, float]:
        """Return the corners of a body in the frame, and the height of its top."""
        corners = self.frame.inv().apply(solid(self.placed[index]).corners)
        return corners, float(corners[:, 2].max())

    def on_another(self) -> None:
        """Place a body on a present body, or on the plane."""
        yaw = Rotation.from_euler("z", self.draw.choice([0.0, 0.5 * pi, self.draw.uniform(0.0, 2.0 * pi)]))
        if not self.placed or self.happens(0.15):
            at, height = np.array([self.draw.uniform(-0.5, 0.5), self.draw.uniform(-0.5, 0.5)]), 0.0
        else:
            corners, height = self.top(self.draw.randrange(len(self.placed)))
            upper = corners[corners[:, 2] > height - 1e-3]
            middle, spread = upper[:, :2].mean(axis=0), np.ptp(corners[:, :2], axis=0)
            at = middle + np.array([self.draw.uniform(-0.4, 0.4) * each for each in spread])
        self.put(self.brick(), at, self.lean() * yaw, height + self.gap())

    def beside(self) -> None:
        """Place a box above a wall square to the plane, rotated slightly so that a corner has a gap."""
        draw = self.draw
        shape = Box((draw.uniform(0.1, 0.4), draw.uniform(0.1, 0.3), draw.uniform(0.05, 0.2)))
        angle = draw.choice([0.0, 10.0 ** draw.uniform(-6.0, -1.7)]) * draw.choice([-1.0, 1.0])
        downhill = self.frame.inv().apply([0.0, 0.0, -1.0]) * (1.0, 1.0, 0.0)
        downhill /= np.linalg.norm(downhill)
        turn = Rotation.from_euler("z", angle + float(np.arctan2(downhill[1], downhill[0])))
        self.put(Brick("b0", shape, 1.0), np.zeros(2), turn, self.gap() if self.happens(0.3) else 0.0)
        low = 0.5 * float(np.ptp(turn.apply(np.array(shape.corners)) @ downhill))
        self.planes.append(
            Plane("wall", self.turned((low + self.gap()) * downhill), self.turned(-downhill), self.friction)
        )

    def neighbour(self) -> None:
        """Place a box beside a present one, with sides near to each other."""
        draw = self.draw
        corners, _ = self.top(draw.randrange(len(self.placed)))
        low, high = corners.min(axis=0), corners.max(axis=0)
        size = (draw.uniform(0.05, 0.3), draw.uniform(0.05, 0.3), draw.uniform(0.02, 0.2))
        small = draw.choice([0.0, 10.0 ** draw.uniform(-6.0, -1.7)])
        turn = Rotation.from_euler("z", small)
        half = 0.5 * np.ptp(turn.apply(np.array(Box(size).corners)), axis=0)
        at = 0.5 * (low + high)[:2]
        axis, sign = draw.randrange(2), draw.choice([-1.0, 1.0])
        at[axis] += sign * (0.5 * (high - low)[axis] + half[axis] + self.gap())
        at[1 - axis] += draw.uniform(-0.5, 0.5) * (half[1 - axis])
        bottom = float(low[2]) + (self.gap() if self.happens(0.3) else 0.0)
        self.put(Brick(f"b{len(self.placed)}", Box(size), draw.uniform(0.1, 3.0)), at, turn, bottom)

    def pillars(self) -> None:
        """Place a plank across two pillars of which one is lower by a gap."""
        draw = self.draw
        height, span, gap = draw.uniform(0.05, 0.2), draw.uniform(0.15, 0.4), self.gap()
        for x, lower in ((-0.5 * span, 0.0), (0.5 * span, gap)):
            size = (draw.uniform(0.05, 0.1), draw.uniform(0.05, 0.1), height - lower)
            self.put(Brick(f"b{len(self.placed)}", Box(size), 1.0), np.array([x, 0.0]), Rotation.identity(), 0.0)
        brick = self.brick((draw.uniform(0.8, 1.5) * span, 0.08, draw.uniform(0.01, 0.05)))
        self.put(brick, np.array([draw.uniform(-0.2, 0.2) * span, 0.0]), self.lean(), height)


def scene(seed: int) -> Scene | None:
    """Return a random assembly; None if bodies would overlap."""
    draw = random.Random(seed)
    kind = draw.random()
    made = Maker(draw, smooth=kind < AT_A_WALL)
    if kind < AT_A_WALL:
        made.beside()
    elif kind < AT_A_WALL + ON_PILLARS:
        made.pillars()
    for _ in range(draw.randint(0 if made.placed else 1, 4)):
        if made.placed and made.happens(0.3):
            made.neighbour()
        else:
            made.on_another()
    made_scene = Scene(tuple(made.planes), made.friction, tuple(made.placed))
    return None if deep(made_scene) else made_scene


def deep(scene: Scene) -> bool:
    """Return whether bodies of a scene overlap by more than a micrometre."""
    bodies = [solid(each) for each in scene.bricks]
    for body in bodies:
        if any(((body.corners - np.array(p.point_W)) @ np.array(p.normal_W)).min() < -INSIDE for p in scene.planes):
            return True
    return any(_overlap(a, b) > INSIDE for a, b in combinations(bodies, 2))


def _overlap(a: Solid, b: Solid) -> float:
    """Return the overlap of two bodies, over the normals of faces and pairs of edges [m]; negative if apart."""
    if (a.corners.min(axis=0) > b.corners.max(axis=0)).any() or (b.corners.min(axis=0) > a.corners.max(axis=0)).any():
        return -1.0
    ways = np.cross(a.ends[1][:, None], b.ends[1][None]).reshape(-1, 3)
    lengths = np.linalg.norm(ways, axis=1)
    lines = np.vstack([a.normals, b.normals, ways[lengths > SMALL] / lengths[lengths > SMALL, None]])
    one, other = lines @ a.corners.T, lines @ b.corners.T
    depths = np.minimum(one.max(axis=1) - other.min(axis=1), other.max(axis=1) - one.min(axis=1))
    return float(depths.min())


# --- verdicts ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Judged:
    """Assembly, its verdict by statics, and the objection of a program."""

    seed: int
    verdict: Verdict
    objection: str = ""  # one of OBJECTIONS

    @property
    def is_across_gaps(self) -> bool:
        """Return whether the verdict depends on gaps as contact."""
        return self.verdict.touching_within > 0.0


OBJECTIONS = ("stable contradicted", "gap not told", "gap told for nothing", "unstable contradicted")


def judged(seed: int) -> Judged | None:
    """Judge a random assembly and check it by the programs; None if bodies would overlap."""
    made = scene(seed)
    if made is None:
        return None
    verdict = Assembly(made.planes, made.friction, overlap=10.0 * INSIDE).add_all(made.bricks)
    return Judged(seed, verdict, objection(made, verdict))


def objection(made: Scene, verdict: Verdict) -> str:
    """Return the objection of a program to a verdict; empty if there is none."""
    bodies = [solid(each) for each in made.bricks]

    def carry(*, wide: bool, gaps: bool) -> bool:
        contacts = points(bodies, made.planes, made.friction, wide=wide)
        return balances(bodies, [each for each in contacts if gaps or not each.is_across_gap], wide=wide)

    if verdict.stability is Stability.UNSTABLE:
        return "unstable contradicted" if carry(wide=False, gaps=False) else ""
    if verdict.stability is not Stability.STABLE:
        return ""
    if not carry(wide=True, gaps=True):
        return "stable contradicted"
    if verdict.touching_within == 0.0:
        return "" if carry(wide=True, gaps=False) else "gap not told"
    return "gap told for nothing" if carry(wide=False, gaps=False) else ""


def summed_up(results: Sequence[Judged]) -> Row:
    """Return the number of verdicts of each kind, and the contradicted ones."""
    verdicts = Counter(each.verdict.stability for each in results)
    objections = Counter(each.objection for each in results if each.objection)
    return {
        "assemblies": len(results),
        "stable": verdicts[Stability.STABLE],
        "across_gaps": sum(each.is_across_gaps for each in results),
        "unstable": verdicts[Stability.UNSTABLE],
        "undecided": verdicts[Stability.UNDECIDED],
        **{objection.replace(" ", "_"): objections[objection] for objection in OBJECTIONS},
        "seeds": " ".join(str(each.seed) for each in results if each.objection) or "none",
    }


def main() -> None:
    """Judge and print the counts; write them on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--assemblies", type=int, default=500)
    arguments.add_argument("--first", type=int, default=0, help="seed to begin with")
    chosen = arguments.parse_args()
    console, results = Console(stderr=True), list[Judged]()
    with Progress(console=console, transient=True) as progress:
        task, seed = progress.add_task("assemblies", total=chosen.assemblies), chosen.first
        while len(results) < chosen.assemblies:
            each, seed = judged(seed), seed + 1
            if each is not None:
                results.append(each)
                progress.advance(task)
    row = summed_up(results)
    Console().print("\n".join(f"{name.replace('_', ' '):>24}  {value}" for name, value in row.items()))
    if chosen.write:
        command = f"python -m benchmarks.touching --assemblies {chosen.assemblies} --write"
        record("touching", command, {"verdicts": {"all": row}})


if __name__ == "__main__":
    main()
