"""Random assemblies of round bodies and boxes, and linear programs of their equilibrium, written apart.

Each disc is a polygon inside or around it, and each friction cone a pyramid inside or around it. With those inside a
solution proves that the bodies can stand; without one with those around, nothing holds them. Contacts follow from
heights and distances of centres, without code of this project.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, hypot, pi, sin

import numpy as np
from scipy.optimize import linprog

from stability.geometry.box import Box
from stability.geometry.round_solid import cylinder, sphere
from stability.geometry.rows import Array
from stability.geometry.vectors import about
from stability.model import Brick, Plane, Pose, Vec3
from stability.problem import Placed

GRAVITY = 9.81  # [m/s2]
SIDES = 48  # of polygons
RIBS = 24  # of pyramids
TALL = 0.1  # [m] height of cans and boxes, and diameter of logs and balls

Point = tuple[float, float]


@dataclass(frozen=True)
class Touch:
    """Forces of one body on another at a point, about a normal, from the first to the second; -1 is fixed."""

    first: int
    second: int
    at: Vec3
    normal: Vec3
    friction: float


@dataclass(frozen=True)
class Case:
    """Placed bodies, and their contacts with polygons inside and around discs."""

    placed: list[Placed]
    planes: tuple[Plane, ...]
    friction: float
    inside: list[Touch]
    around: list[Touch]

    def can_stand(self) -> bool:
        """Return whether forces of pyramids inside all cones balance the weights."""
        return self._solvable(self.inside, 1.0)

    def may_stand(self) -> bool:
        """Return whether forces of pyramids around all cones balance the weights."""
        return self._solvable(self.around, 1.0 / cos(pi / RIBS))

    def _solvable(self, touches: list[Touch], wider: float) -> bool:
        columns = []
        for touch in touches:
            normal = np.array(touch.normal)
            first = np.cross(normal, np.identity(3)[int(np.abs(normal).argmin())])
            first /= np.linalg.norm(first)
            second = np.cross(normal, first)
            for rib in range(RIBS):
                angle = 2.0 * pi * rib / RIBS
                across = wider * touch.friction * (cos(angle) * first + sin(angle) * second)
                column = np.zeros(6 * len(self.placed))
                for body, sign in ((touch.first, -1.0), (touch.second, 1.0)):
                    if body >= 0:
                        force = sign * (normal + across)
                        arm = np.array(touch.at) - np.array(self.placed[body].pose.position_W)
                        column[6 * body : 6 * body + 6] = np.concatenate([force, np.cross(arm, force) / TALL])
                columns.append(column)
        weights = np.zeros(6 * len(self.placed))
        weights[2::6] = [GRAVITY * each.brick.mass for each in self.placed]
        found = linprog(np.ones(len(columns)), A_eq=np.array(columns).T, b_eq=weights, method="highs")
        return bool(found.status == 0)


def outline(placed: Placed, around: bool) -> list[Point]:
    """Return a polygon of the section of an upright can or box."""
    x, y, _ = placed.pose.position_W
    shape = placed.brick.shape
    if isinstance(shape, Box):
        yaw = 2.0 * np.arctan2(placed.pose.orientation[2], placed.pose.orientation[3])
        half = (0.5 * shape.size[0], 0.5 * shape.size[1])
        corners = [(i * half[0], j * half[1]) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        return [(x + cos(yaw) * u - sin(yaw) * v, y + sin(yaw) * u + cos(yaw) * v) for u, v in corners]
    radius = shape.radii[0] / (cos(pi / SIDES) if around else 1.0)  # type: ignore[attr-defined]  # a can
    return [(x + radius * cos(2 * pi * k / SIDES), y + radius * sin(2 * pi * k / SIDES)) for k in range(SIDES)]


def common(one: list[Point], other: list[Point]) -> list[Point]:
    """Return the intersection of two convex polygons (Sutherland and Hodgman)."""
    for (ax, ay), (bx, by) in zip(other, [*other[1:], other[0]], strict=True):
        depths = [(bx - ax) * (y - ay) - (by - ay) * (x - ax) for x, y in one]
        kept: list[Point] = []
        for i, (x, y) in enumerate(one):
            (u, v), here, there = one[i - 1], depths[i], depths[i - 1]
            if (here >= 0.0) != (there >= 0.0):
                share = there / (there - here)
                kept.append((u + share * (x - u), v + share * (y - v)))
            if here >= 0.0:
                kept.append((x, y))
        one = kept
        if not one:
            break
    return one


def stack(random: np.random.Generator) -> Case:
    """Return cans and boxes on some levels, each over at least one below."""
    placed: list[Placed] = []
    level: list[int] = []
    for height in range(int(random.integers(2, 5))):
        now: list[int] = []
        for _ in range(int(random.integers(1, 4))):
            on = placed[int(random.choice(level))].pose.position_W if level else (0.0, 0.0, 0.0)
            reach = 0.25 if not level else 0.06
            at = (on[0] + random.uniform(-reach, reach), on[1] + random.uniform(-reach, reach))
            beside = [placed[i].pose.position_W for i in now]
            if any(hypot(at[0] - x, at[1] - y) < 0.125 for x, y, _ in beside):
                continue
            shape = cylinder(random.uniform(0.03, 0.06), TALL) if random.random() < 0.7 else Box((0.09, 0.07, TALL))
            pose = Pose((*at, (height + 0.5) * TALL), about((0.0, 0.0, 1.0), random.uniform(0.0, pi)))
            now.append(len(placed))
            placed.append(Placed(Brick(f"b{len(placed)}", shape, float(random.choice([0.5, 1.0, 4.0]))), pose))
        level = now or level
        if not now:
            break
    friction = float(random.uniform(0.1, 0.8))
    touches: list[list[Touch]] = [[], []]
    for around, found in zip((False, True), touches, strict=True):
        shapes = [outline(each, around) for each in placed]
        for i, upper in enumerate(placed):
            low = upper.pose.position_W[2] - 0.5 * TALL
            if low < 0.5 * TALL:
                found += [Touch(-1, i, (*p, 0.0), (0.0, 0.0, 1.0), friction) for p in shapes[i]]
            for j, lower in enumerate(placed):
                if abs(lower.pose.position_W[2] + 0.5 * TALL - low) < 0.5 * TALL:
                    area = common(shapes[i], shapes[j])
                    found += [Touch(j, i, (*p, low), (0.0, 0.0, 1.0), friction) for p in area]
    ground = Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction)
    return Case(placed, (ground,), friction, touches[0], touches[1])


def pile(random: np.random.Generator, balls: bool) -> Case:
    """Return logs (balls) of different size, each on two (three) earlier ones, walls or the floor."""
    friction, rough = float(random.uniform(0.05, 0.9)), float(random.uniform(0.05, 0.9))
    lean = float(random.uniform(0.0, 0.4))
    sides = [(1.0, 0.0), (-1.0, 0.0), *([(0.0, 1.0), (0.0, -1.0)] if balls else [])]
    wide = float(random.uniform(0.12, 0.3))
    planes = [Plane("floor", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), rough)]
    for i, (x, y) in enumerate(sides):
        planes.append(Plane(f"w{i}", (-wide * x, -wide * y, 0.0), (cos(lean) * x, cos(lean) * y, sin(lean)), rough))
    known: list[tuple[Vec3, float]] = []
    for _ in range(int(random.integers(2, 7))):
        radius = float(random.uniform(0.04, 0.07))
        at = resting(random, planes, known, radius, balls)
        if at is not None:
            known.append((at, radius))
    turn = about((1.0, 0.0, 0.0), 0.5 * pi)
    placed = [
        Placed(Brick(f"b{i}", sphere(radius) if balls else cylinder(radius, 0.3), 1000.0 * radius**2), Pose(at, turn))
        for i, (at, radius) in enumerate(known)
    ]
    touches: list[Touch] = []
    ends = (0.0,) if balls else (-0.15, 0.15)
    for i, (at, radius) in enumerate(known):
        for number, plane in enumerate(planes):
            if abs(_gap(planes, known, number, np.array(at), radius)[0]) < 1e-7:
                foot = np.array(at) - radius * np.array(plane.normal_W)
                touches += [Touch(-1, i, (foot[0], foot[1] + y, foot[2]), plane.normal_W, rough) for y in ends]
        for j, (other, own) in enumerate(known[:i]):
            way = np.subtract(at, other)
            far = float(np.linalg.norm(way))
            if abs(far - radius - own) < 1e-7:
                spot = np.array(other) + own * way / far
                normal = (way[0] / far, way[1] / far, way[2] / far)
                touches += [Touch(j, i, (spot[0], spot[1] + y, spot[2]), normal, friction) for y in ends]
    return Case(placed, tuple(planes), friction, touches, touches)


def resting(
    random: np.random.Generator, planes: list[Plane], known: list[tuple[Vec3, float]], radius: float, balls: bool
) -> Vec3 | None:
    """Return a free place that touches as many others as it takes to hold a body; None if none is found."""
    count = 3 if balls else 2
    for _ in range(60):
        chosen = random.permutation(len(planes) + len(known))[:count]
        aside = random.uniform(-0.2, 0.2) if balls else 0.0
        at = np.array([random.uniform(-0.2, 0.2), aside, random.uniform(0.05, 0.4)])
        for _ in range(40):  # Newton's method for the gaps to the chosen bodies
            values, slopes = zip(*(_gap(planes, known, int(k), at, radius) for k in chosen), strict=True)
            slope = np.array(slopes) if balls else np.array(slopes)[:, [0, 2]]
            step = np.linalg.lstsq(slope, -np.array(values), rcond=None)[0]
            at = at + (step if balls else np.array([step[0], 0.0, step[1]]))
            if np.abs(at).max() > 10.0:
                break
        gaps = [_gap(planes, known, k, at, radius)[0] for k in range(len(planes) + len(known))]
        chosen_gaps = [abs(gaps[int(k)]) for k in chosen]
        # All others are clearly apart, so that no contact hangs on rounding.
        rest = [gap for k, gap in enumerate(gaps) if k not in chosen]
        if max(chosen_gaps) < 1e-12 and min(rest, default=1.0) > 0.005:
            return (float(at[0]), float(at[1]), float(at[2]))
    return None


def _gap(planes: list[Plane], known: list[tuple[Vec3, float]], k: int, at: Array, radius: float) -> tuple[float, Array]:
    """Return the gap of a ball to a plane or an earlier ball [m], and its slope along the place of the ball."""
    if k < len(planes):
        plane = planes[k]
        normal = np.array(plane.normal_W)
        return float((at - np.array(plane.point_W)) @ normal) - radius, normal
    centre, own = known[k - len(planes)]
    way = at - np.array(centre)
    far = float(np.linalg.norm(way)) or 1e-15
    return far - radius - own, way / far


KINDS: dict[str, Callable[[np.random.Generator], Case]] = {
    "stacks": stack,
    "logs": lambda random: pile(random, balls=False),
    "balls": lambda random: pile(random, balls=True),
}
