"""Closes the open joints between imported stones of any shape by the least moves.

A joint is a pair of faces of two stones, or of a stone and the ground, that face each other within the gap that the
author allows. Joints are closed when the faces lie in one plane. The moves and rotations of all stones are the smallest
that close all joints: a least-norm solution of the linearised conditions, renewed until rounding (Gauss-Newton).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import Final

import numpy as np

from stability.geometry.polygons import clip, doubled_area
from stability.geometry.rows import Array
from stability.geometry.spatial_grid import Neighbours
from stability.model import Vec3
from stackdsl.importers.load import Exact3, ImportedBox, ImportedLoad

FACING: Final = 0.97  # least cosine of the angle by which two faces face each other
SHARED: Final = 0.05  # share of the smaller of two faces that they have at least in common
ROUNDS: Final = 40  # a dozen suffice; where joints say nearly the same twice, each halves the residual
WHOLE: Final = 5  # rounds that find the whole moves anew; the later ones correct them
RANK: Final = 1e-10  # ratio of singular values below which joints say the same twice
CLOSED: Final = 1e-8  # residual of a joint that is closed [m]; of stones larger than a metre, a share of their size
STILL: Final = 1e-12  # share of the size of a stone: a smaller move is rounding
GROUND: Final = -1  # index of the ground
MOST_STONES: Final = 300  # the time grows with the cube of their number; 300 take a minute


class OpenJointError(Exception):
    """Joints cannot be closed; names the stone."""

    def __init__(self, box: ImportedBox, message: str, hint: str) -> None:
        super().__init__(message)
        self.box, self.message, self.hint = box, message, hint


@dataclass(frozen=True, slots=True)
class ClosedLoad:
    """A load with closed joints, and how far each stone moved."""

    load: ImportedLoad
    moved: tuple[float, ...]  # of the corner that moved most [m]
    turned: tuple[float, ...]  # [rad]


@dataclass(frozen=True, slots=True, eq=False)
class _Stone:
    """A stone where the file places it."""

    corners: Array  # (n, 3) of all parts, in the frame of the file [m]
    faces: list[Array]  # corners of each, counter-clockwise seen from outside
    centre: Array  # mean of the corners
    radius: float  # [m]


@dataclass(frozen=True, slots=True, eq=False)
class _Joint:
    """Faces that shall touch: points of the face of one stone, and the plane of the other's."""

    on: int  # the stone of the plane, or GROUND
    point: Array  # of the plane, in the frame of the file
    normal: Array  # of the plane, outwards
    of: int  # the stone of the points
    points: Array  # (n, 3)


def with_closed_joints(load: ImportedLoad, within: Fraction) -> ClosedLoad:
    """Close all joints of at most a gap [m] by the least moves. Raises OpenJointError.

    No corner moves by more than the gap.
    """
    if len(load.boxes) > MOST_STONES:
        message = f"joints of {len(load.boxes)} stones take too long to close"
        raise OpenJointError(load.boxes[0], message, f"import at most {MOST_STONES} stones, or write `as written`")
    stones = [_stone(box) for box in load.boxes]
    joints = list(_joints(stones, float(within)))
    moves = _least_moves(stones, joints)
    residuals = _heights(joints, _frames(stones, moves))
    within_rounding = _residual(stones)
    for joint, heights in zip(joints, residuals, strict=True):
        if np.abs(heights).max() > within_rounding:
            other = "the ground" if joint.on == GROUND else f"'{_name(load.boxes[joint.on])}'"
            message = (
                f"not all joints can be closed: {1000.0 * np.abs(heights).max():.3g} mm remain between "
                f"'{_name(load.boxes[joint.of])}' and {other}"
            )
            raise OpenJointError(
                load.boxes[joint.of], message, "write a smaller gap, or correct the stones in the file"
            )
    shifts = [_shift(stone, move) for stone, move in zip(stones, moves, strict=True)]
    farthest = int(np.argmax(shifts)) if shifts else 0
    if shifts and shifts[farthest] > float(within) * (1.0 + CLOSED):
        box = load.boxes[farthest]
        message = f"closing the joints moves '{_name(box)}' by {1000.0 * shifts[farthest]:.3g} mm, more than the gap"
        raise OpenJointError(box, message, "write a larger gap if this is right")
    boxes = tuple(
        _moved(box, stone, move) if shift > STILL * stone.radius else box
        for box, stone, move, shift in zip(load.boxes, stones, moves, shifts, strict=True)
    )
    turned = tuple(float(np.linalg.norm(move[3:])) for move in moves)
    return ClosedLoad(replace(load, boxes=boxes), tuple(shifts), turned)


def _name(box: ImportedBox) -> str:
    return box.name or f"the stone in line {box.span.line}"


def _stone(box: ImportedBox) -> _Stone:
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 -- few imports need scipy

    from stability.geometry.solid_making import hull_faces  # noqa: PLC0415 -- few imports need scipy

    centre = np.array([float(part) for part in box.centre])
    turn = Rotation.from_euler("xyz", [float(part) for part in box.turn], degrees=True)
    corners, faces = [], []
    for part in box.parts or (box.corners or _corners_of(box),):
        points: list[Vec3] = [(float(x), float(y), float(z)) for x, y, z in part]
        of_part, loops, _ = hull_faces(points)
        placed = turn.apply(np.array(of_part)) + centre
        corners.append(placed)
        faces += [placed[list(loop)] for loop in loops]
    whole = np.concatenate(corners)
    middle = whole.mean(axis=0)
    return _Stone(whole, faces, middle, float(np.linalg.norm(whole - middle, axis=1).max()))


def _corners_of(box: ImportedBox) -> tuple[Exact3, ...]:
    return tuple(product(*((-side / 2, side / 2) for side in box.size)))  # type: ignore[arg-type]  # three sides


def _joints(stones: Sequence[_Stone], within: float) -> Iterator[_Joint]:
    """Yield the joints of at most a gap [m]."""
    near: Neighbours[int] = Neighbours()
    for number, stone in enumerate(stones):
        yield from _on_ground(number, stone, within)
        low, high = (tuple(corner.tolist()) for corner in (stone.corners.min(axis=0), stone.corners.max(axis=0)))
        for other in near.around(low, high, within):
            for face, facing in product(stone.faces, stones[other].faces):
                points = _common(face, facing, within)
                if points is not None:
                    yield _Joint(other, facing.mean(axis=0), _normal(facing), number, points)
        near.add(number, low, high)


def _on_ground(number: int, stone: _Stone, within: float) -> Iterator[_Joint]:
    up = np.array((0.0, 0.0, 1.0))
    for face in stone.faces:
        if _normal(face) @ up < -FACING and np.abs(face[:, 2]).max() <= within:
            yield _Joint(GROUND, np.zeros(3), up, number, face)


def _normal(face: Array) -> Array:
    arms = face - face[0]
    total = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
    normal: Array = total / np.linalg.norm(total)
    return normal


def _common(face: Array, other: Array, within: float) -> Array | None:
    """Return the corners of a face's part in front of another face; None if the faces do not bound a joint."""
    normal, own = _normal(other), _normal(face)
    if normal @ own > -FACING:
        return None
    first = other[1] - other[0]
    first = first / np.linalg.norm(first)
    second = np.cross(normal, first)
    flat = [
        [(float(x), float(y)) for x, y in (each - other[0]) @ np.column_stack((first, second))]
        for each in (face, other)
    ]
    polygons = [tuple(each) if doubled_area(each)[0] > 0.0 else tuple(each[::-1]) for each in flat]
    shared = clip(polygons[0], polygons[1])
    least = min(abs(doubled_area(each)[0]) for each in polygons)
    if len(shared) < 3 or abs(doubled_area(shared)[0]) < SHARED * least:  # noqa: PLR2004 -- a polygon has three corners
        return None
    at = other[0] + np.array(shared) @ np.array((first, second))
    # On the plane of the face, along the normal of the other one.
    heights = (face[0] - at) @ own / (normal @ own)
    if np.abs(heights).max() > within:
        return None
    points: Array = at + heights[:, None] * normal
    return points


def _frames(stones: Sequence[_Stone], moves: Array) -> list[tuple[Array, Array, Array]]:
    """Return the centre of each stone, its rotation matrix, and its new centre."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 -- few imports need scipy

    return [
        (stone.centre, Rotation.from_rotvec(move[3:]).as_matrix(), stone.centre + move[:3])
        for stone, move in zip(stones, moves, strict=True)
    ]


def _placed(points: Array, frame: tuple[Array, Array, Array]) -> Array:
    centre, turn, now = frame
    placed: Array = (points - centre) @ turn.T + now
    return placed


def _heights(joints: Sequence[_Joint], frames: Sequence[tuple[Array, Array, Array]]) -> list[Array]:
    """Return the heights of the points of each joint over its plane [m]."""
    heights = []
    for joint in joints:
        normal, point = joint.normal, joint.point
        if joint.on != GROUND:
            normal, point = frames[joint.on][1] @ normal, _placed(point, frames[joint.on])
        heights.append((_placed(joint.points, frames[joint.of]) - point) @ normal)
    return heights


def _residual(stones: Sequence[_Stone]) -> float:
    """Return the largest height of a point over its plane in a joint that is closed [m]."""
    return CLOSED * max(1.0, *(stone.radius for stone in stones))


def _least_moves(stones: Sequence[_Stone], joints: Sequence[_Joint]) -> Array:
    """Return translation and rotation vector of each stone (n, 6) [m, rad]; of least norm as lengths at the corners."""
    from scipy.linalg import lstsq  # noqa: PLC0415 -- few imports need scipy

    moves = np.zeros((len(stones), 6))
    scale = np.array([(1.0, 1.0, 1.0, *(3 * (1.0 / stone.radius,))) for stone in stones]).reshape(-1, 6)
    for number in range(ROUNDS if joints else 0):
        frames = _frames(stones, moves)
        heights = np.concatenate(_heights(joints, frames))
        if float(np.abs(heights).max()) <= 0.1 * _residual(stones):
            break
        matrix = _rows(joints, frames, len(stones)) * scale.ravel()
        so_far = (moves / scale).ravel() if number < WHOLE else np.zeros(moves.size)
        solution, _, _, _ = lstsq(
            matrix, matrix @ so_far - heights, cond=RANK, lapack_driver="gelsy", check_finite=False
        )
        moves = solution.reshape(-1, 6) * scale + (0.0 if number < WHOLE else moves)
    return moves


def _rows(joints: Sequence[_Joint], frames: Sequence[tuple[Array, Array, Array]], stones: int) -> Array:
    """Return the derivatives of all heights by the moves of all stones (heights, 6 stones)."""
    rows = np.zeros((sum(len(joint.points) for joint in joints), 6 * stones))
    first = 0
    for joint in joints:
        points = _placed(joint.points, frames[joint.of])
        normal = joint.normal if joint.on == GROUND else frames[joint.on][1] @ joint.normal
        for stone, sign in ((joint.of, 1.0), (joint.on, -1.0)):
            if stone != GROUND:
                arms = np.cross(points - frames[stone][2], normal)
                block = sign * np.hstack((np.tile(normal, (len(points), 1)), arms))
                rows[first : first + len(points), 6 * stone : 6 * stone + 6] += block
        first += len(points)
    return rows


def _shift(stone: _Stone, move: Array) -> float:
    """Return how far the corner of a stone that moves most moves [m]."""
    (frame,) = _frames([stone], move[None, :])
    return float(np.linalg.norm(_placed(stone.corners, frame) - stone.corners, axis=1).max())


def _moved(box: ImportedBox, stone: _Stone, move: Array) -> ImportedBox:
    """Return a stone after its move: a box that does not turn stays a box."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 -- few imports need scipy

    (frame,) = _frames([stone], move[None, :])
    centre = np.array([float(part) for part in box.centre])
    now = _placed(centre, frame)
    if float(np.linalg.norm(move[3:])) <= STILL:
        return replace(box, centre=_exact(now))
    turn = frame[1] @ Rotation.from_euler("xyz", [float(part) for part in box.turn], degrees=True).as_matrix()

    def turned(points: Sequence[Exact3]) -> tuple[Exact3, ...]:
        return tuple(_exact(turn @ np.array([float(part) for part in point])) for point in points)

    return replace(
        box,
        centre=_exact(now),
        turn=(Fraction(0), Fraction(0), Fraction(0)),
        corners=turned(box.corners or _corners_of(box)),
        parts=tuple(turned(part) for part in box.parts) if box.parts is not None else None,
        centre_of_mass=None if box.centre_of_mass is None else turned([box.centre_of_mass])[0],
    )


def _exact(point: Array) -> Exact3:
    x, y, z = (Fraction(part) for part in point.tolist())
    return (x, y, z)


def closed_lines(found: ClosedLoad) -> Iterator[str]:
    """Yield a line for each stone that moved, the one that moved most first."""
    order = sorted(range(len(found.moved)), key=lambda number: -found.moved[number])
    moved = [number for number in order if found.moved[number] > CLOSED]
    yield f"{len(moved)} of {len(found.moved)} stones were moved to close joints"
    for number in moved:
        turned = f", turned by {np.degrees(found.turned[number]):.3g} deg" if found.turned[number] > CLOSED else ""
        yield f"  {_name(found.load.boxes[number])}: {1000.0 * found.moved[number]:.3g} mm{turned}"
