"""Propagates weights downwards brick by brick: a proof of rest by vertical forces."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from stability.geometry.polygons import Point2, depth, extent, hull
from stability.graph import from_the_top
from stability.model import BodyId
from stability.problem import ZERO, Contact, Problem, Wrench
from stability.statics.load_core import ON_THE_BORDER, LoadCore, carries_upright, piece, plan

# Weight propagation brick by brick: the second stage of the cascade.
#
# Each brick passes its weight, and the loads passed to it, to the bodies below by vertical forces at the corners of its
# contact patches. Of all balancing forces those of least norm are taken: a pressure that is linear over the corners,
# and zero where it would pull, f = max(0, a + b x + c y). Loads that leave the group must act inside the load cores of
# the bodies below. If every brick succeeds, the forces balance the whole group. If one fails, another distribution
# might succeed: a failure proves nothing.


MOST_TURNS = 30  # of the search for the loaded corners; four or five are usual, and later stages take over
ROUNDING = 1e-12  # relative error of a balance; well below the residual that proofs allow
# Share of the products whose sum is a determinant, some tens of their rounding errors: corners with a smaller
# determinant lie on a line, within rounding.
SINGULAR = 1e-14
TINIEST = 1e-300  # close to the smallest normal float, 2e-308: replaces products that all underflow to zero


@dataclass(frozen=True, slots=True)
class VerticalLoad:
    """Vertical load: its weight [N] and its point of application in plan [m]."""

    weight: float
    at: Point2

    def plus(self, other: "VerticalLoad") -> "VerticalLoad":
        """Return the sum of both loads."""
        total = self.weight + other.weight
        if total <= 0.0:
            return self
        part = other.weight / total
        x, y = self.at
        return VerticalLoad(total, (x + part * (other.at[0] - x), y + part * (other.at[1] - y)))


@dataclass(frozen=True, slots=True)
class VerticalForce:
    """Vertical force through a contact, from the upper body to the lower one."""

    contact: Contact
    load: VerticalLoad


@dataclass(frozen=True, slots=True)
class Failure:
    """Brick that could not pass its load down."""

    brick: BodyId
    load: VerticalLoad
    hinders: tuple[BodyId, ...]  # bricks below whose cores were too small


Patches: TypeAlias = Sequence[tuple[Contact, tuple[Point2, ...]]]


def propagate(
    order: Iterable[BodyId],
    weights: Mapping[BodyId, VerticalLoad],
    supports: Mapping[BodyId, Sequence[Contact]],
    cores: Mapping[BodyId, LoadCore],
) -> list[VerticalForce] | Failure:
    """Pass down the weights of a group; `order` lists its bricks, each after the group's bricks on it."""
    loads = dict(weights)
    vertical: list[VerticalForce] = []
    for brick in order:
        patches = _patches(supports[brick], weights.keys(), cores)
        handed = shared(loads[brick], patches)
        if handed is None:
            hinders = tuple(c.lower for c in supports[brick] if c.lower not in weights and c.lower in cores)
            return Failure(brick, loads[brick], hinders)
        for force in handed:
            vertical.append(force)
            lower = force.contact.lower
            if lower in loads:
                loads[lower] = loads[lower].plus(force.load)
    return vertical


def _patches(
    supports: Sequence[Contact], group: Collection[BodyId], cores: Mapping[BodyId, LoadCore]
) -> list[tuple[Contact, tuple[Point2, ...]]]:
    """Return the contacts of a brick, with the corners at which each may be loaded."""
    patches = []
    for contact in supports:
        below = None if contact.lower in group else cores.get(contact.lower)
        points = piece(plan(contact), below)
        if points:
            patches.append((contact, points))
    return patches


def shared(load: VerticalLoad, patches: Patches) -> list[VerticalForce] | None:
    """Return the forces of least norm that carry a load, one per loaded contact; None if there are none."""
    if len(patches) == 1 and len(patches[0][1]) > 2:  # noqa: PLR2004 -- all of the load passes through a single patch
        contact, points = patches[0]
        inside = depth(load.at, points) >= -ON_THE_BORDER * extent(points)
        return [VerticalForce(contact, load)] if inside else None
    corners = [point for _, points in patches for point in points]
    forces = least_norm(load.at, corners)
    if forces is None:
        return None
    handed = []
    start = 0
    for contact, points in patches:
        own = forces[start : start + len(points)]
        start += len(points)
        total = sum(own)
        if total > 0.0:
            x = sum(force * point[0] for force, point in zip(own, points, strict=True)) / total
            y = sum(force * point[1] for force, point in zip(own, points, strict=True)) / total
            handed.append(VerticalForce(contact, VerticalLoad(total * load.weight, (x, y))))
    return handed


def least_norm(load: Point2, corners: Sequence[Point2]) -> list[float] | None:
    """Return non-negative forces of least norm at the corners that balance a unit load.

    The minimum has the form f = max(0, u + v x + w y) (its Karush-Kuhn-Tucker conditions); Newton's method on the set
    of loaded corners finds it. None if the load lies outside their hull, or if that set is not found.
    """
    if not corners:
        return None
    lx, ly = load
    xs, ys = [x - lx for x, _ in corners], [y - ly for _, y in corners]
    left, right, near, far = min(xs), max(xs), min(ys), max(ys)
    scale = max(right, -left, far, -near)
    if scale == 0.0:
        return [1.0 / len(corners)] * len(corners)
    reach = ON_THE_BORDER * scale
    if left > reach or right < -reach or near > reach or far < -reach:
        return None  # outside the bounding rectangle of the corners
    points = [(x / scale, y / scale) for x, y in zip(xs, ys, strict=True)]
    pressing, pressed = [True] * len(points), points
    for _ in range(MOST_TURNS):
        pressure = _plane(pressed)
        if pressure is None:
            return None if hull(corners) else _on_a_line(load, corners)
        u, v, w = pressure
        heights = [u + v * x + w * y for x, y in points]
        now = [height > 0.0 for height in heights]
        if now == pressing:
            forces = [height if height > 0.0 else 0.0 for height in heights]
            return forces if _balances(forces, points) else None
        pressing, pressed = now, [point for point, presses in zip(points, now, strict=True) if presses]
    return None


def _plane(points: Sequence[Point2]) -> tuple[float, float, float] | None:
    """Return the linear pressure over these points that balances a unit load at the origin."""
    n = float(len(points))
    sx = sy = sxx = syy = sxy = 0.0
    for x, y in points:
        sx += x
        sy += y
        sxx += x * x
        syy += y * y
        sxy += x * y
    # Cramer's rule on the normal equations [[n, sx, sy], [sx, sxx, sxy], [sy, sxy, syy]] (u, v, w) = (1, 0, 0).
    cu, cv, cw = sxx * syy - sxy * sxy, sxy * sy - sx * syy, sx * sxy - sxx * sy
    determinant = n * cu + sx * cv + sy * cw
    if abs(determinant) <= SINGULAR * n * max(sxx * syy, sx * sx * syy, sy * sy * sxx, TINIEST):
        return None
    return cu / determinant, cv / determinant, cw / determinant


def _balances(forces: Sequence[float], points: Sequence[Point2]) -> bool:
    """Return whether forces balance a unit load: close to the border of the hull the equations lose digits."""
    total = moment_x = moment_y = 0.0
    for force, (x, y) in zip(forces, points, strict=True):
        total += force
        moment_x += force * x
        moment_y += force * y
    return abs(total - 1.0) < ROUNDING and abs(moment_x) < ROUNDING and abs(moment_y) < ROUNDING


def _on_a_line(load: Point2, corners: Sequence[Point2]) -> list[float] | None:
    """Return forces of least norm at collinear or equal corners by least squares, if none of them pulls."""
    if not corners:
        return None
    import numpy as np  # noqa: PLC0415 -- it takes longer to load than most scenes to judge, and hardly any comes here

    matrix = np.array([[1.0] * len(corners), [x - load[0] for x, _ in corners], [y - load[1] for _, y in corners]])
    scale = float(np.abs(matrix[1:]).max()) or 1.0
    matrix[1:] /= scale
    forces: list[float] = (np.linalg.pinv(matrix) @ np.array([1.0, 0.0, 0.0])).tolist()
    points = [(float(x), float(y)) for x, y in matrix[1:].T]
    return [max(0.0, f) for f in forces] if min(forces) > -ROUNDING and _balances(forces, points) else None


# Balances a problem by vertical forces, brick by brick. If this succeeds, no motion is searched.
#
# All bodies outside the problem are held fixed. A failure proves nothing.


def is_held_upright(problem: Problem) -> bool:
    """Return whether weight propagation balances all loads of a problem, which must be weights."""
    weights = _weights(problem)
    if weights is None:
        return False
    supports: dict[BodyId, list[Contact]] = {name: [] for name in problem.bricks}
    for contact in problem.contacts:
        if contact.upper in supports and carries_upright(contact):
            supports[contact.upper].append(contact)
    if not all(supports.values()):
        return False
    order = from_the_top({name: [c.lower for c in below if c.lower in supports] for name, below in supports.items()})
    if len(order) < len(supports):
        return False  # bricks that rest on one another in a ring
    return not isinstance(propagate(order, weights, supports, {}), Failure)


def _weights(problem: Problem) -> Mapping[BodyId, VerticalLoad] | None:
    """Return the loads as weights at the centres of mass; None if one of them is not a weight."""
    weights = {}
    for name, placed in problem.bricks.items():
        load = problem.loads.get(name, Wrench(ZERO))
        x, y, z = load.force_W
        if x != 0.0 or y != 0.0 or not z < 0.0 or load.torque_W != ZERO:
            return None
        weights[name] = VerticalLoad(-z, placed.pose.position_W[:2])
    return weights
