"""The line of thrust of contact forces, and the hinges where it reaches an edge of a joint."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from stability.geometry.rows import Array
from stability.model import BodyId, Vec3

AT_EDGE: Final = 1e-3  # share of the width of a joint: a force that is nearer to its edge makes a hinge
FAINT: Final = 1e-6  # share of the largest force: smaller ones have no thrust
AREA: Final = 3  # corners
FLAT: Final = 1e-6  # share of the length of a joint: narrower ones are edges


@dataclass(frozen=True, slots=True)
class JointForces:
    """The forces at the points of a joint."""

    lower: BodyId
    upper: BodyId
    points_W: Sequence[Vec3]  # [m]
    forces_W: Sequence[Vec3]  # of `lower` on `upper` [N]


@dataclass(frozen=True, slots=True)
class ThrustLine:
    """The way of forces through one brick, from joint to joint."""

    brick: BodyId
    begin_W: Vec3  # [m]
    end_W: Vec3
    force: float  # the larger one at its ends [N]


@dataclass(frozen=True, slots=True)
class Thrust:
    """The line of thrust of a structure."""

    lines: tuple[ThrustLine, ...]
    hinges: tuple[tuple[BodyId, Vec3], ...]  # upper body, and place [m]


def thrust_of(joints: Iterable[JointForces], bricks: Collection[BodyId]) -> Thrust:
    """Return the line of thrust: in each brick, from where forces press from above to where they go out below.

    Other bodies than `bricks` are fixed.
    """
    known = [_Joint.of(joint) for joint in joints if joint.forces_W]
    most = max((joint.size for joint in known), default=0.0)
    pressed = [joint for joint in known if joint.size > FAINT * most]
    around: dict[BodyId, list[tuple[_Joint, Array]]] = {}
    for joint in pressed:
        around.setdefault(joint.upper, []).append((joint, joint.force))
        around.setdefault(joint.lower, []).append((joint, -joint.force))
    lines = [line for brick, ends in sorted(around.items()) if brick in bricks for line in _through(brick, ends)]
    hinges = [(joint.upper, _vector(joint.point)) for joint in pressed if joint.is_hinge]
    return Thrust(tuple(lines), tuple(hinges))


@dataclass(frozen=True, slots=True, eq=False)
class _Joint:
    lower: BodyId
    upper: BodyId
    point: Array  # (3,) where the forces act together [m]
    force: Array  # (3,) on the upper body [N]
    size: float
    is_hinge: bool

    @classmethod
    def of(cls, joint: JointForces) -> "_Joint":
        points, forces = np.array(joint.points_W, dtype=float), np.array(joint.forces_W, dtype=float)
        total = forces.sum(axis=0)
        size = float(np.linalg.norm(total))
        # Forces in the plane of a joint have no moment about its axes, so those across it give the place.
        pressure = np.abs(forces @ _across(points, total))
        point = pressure @ points / pressure.sum() if pressure.sum() > 0.0 else points.mean(axis=0)
        return cls(joint.lower, joint.upper, point, total, size, _is_at_edge(points, point))


def _across(points: Array, total: Array) -> Array:
    """Return a vector across a flat area, or along the resultant if an edge or a corner touches."""
    if len(points) < AREA:
        return total
    _, sizes, axes = np.linalg.svd(points - points.mean(axis=0))
    across: Array = axes[2] if sizes[1] > FLAT * sizes[0] else total
    return across


def _is_at_edge(points: Array, point: Array) -> bool:
    """Return whether a point of a flat convex area lies on its border; an edge that touches is one."""
    middle = points.mean(axis=0)
    spread = np.linalg.svd(points - middle, full_matrices=False)
    axes = spread[2][:2]
    if len(points) < AREA or spread[1][1] < FLAT * spread[1][0]:
        return True
    for axis in axes:
        along = (points - middle) @ axis
        low, high = float(along.min()), float(along.max())
        place = float((point - middle) @ axis)
        if min(place - low, high - place) < AT_EDGE * (high - low):
            return True
    return False


def _through(brick: BodyId, ends: Sequence[tuple[_Joint, Array]]) -> Iterable[ThrustLine]:
    """Yield the lines through a brick that touches others: from forces that press it to those that hold it."""
    holding = [joint for joint, force in ends if force[2] > 0.0]
    pressing = [joint for joint, force in ends if force[2] <= 0.0]
    if not holding or not pressing:
        pairs = [(ends[0][0], joint) for joint, _ in ends[1:]]  # between walls, or beside each other
    else:
        pairs = [(above, below) for above in pressing for below in holding]
        if len(pressing) > 1 and len(holding) > 1:  # each force from above goes to the support that is nearest
            pairs = [(above, min(holding, key=lambda each: float(np.linalg.norm(each.point - above.point))))
                     for above in pressing]  # fmt: skip
    for one, other in pairs:
        yield ThrustLine(brick, _vector(one.point), _vector(other.point), max(one.size, other.size))


def _vector(row: Array) -> Vec3:
    x, y, z = row.tolist()
    return (x, y, z)
