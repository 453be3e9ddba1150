"""Conversion between bricks and numpy arrays, for packers and robots with many bricks.

Everything is in SI units, in W, z up. A quaternion is x, y, z, w: the real part last, as in ROS, PyBullet and SciPy,
and not first as in MuJoCo and Drake.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stability.geometry.box import Box
from stability.geometry.placed_shape import bounds_W
from stability.geometry.rows import Array
from stability.geometry.vectors import admit_numbers, listed, short_repr
from stability.model import IDENTITY, BodyId, Brick, ConvexShape, Pose, Quaternion, Vec3
from stability.problem import Placed
from stability.statics.assembly import AssemblyAnswers


@dataclass(frozen=True, slots=True, eq=False)
class BrickArrays:
    """Bricks of an assembly, in the order in which they were added."""

    names: tuple[BodyId, ...]  # of n bricks
    positions: Array  # (n, 3) of the centres of mass [m]
    orientations: Array  # (n, 4) unit quaternions x, y, z, w
    masses: Array  # (n,) [kg]
    bounds: Array  # (n, 2, 3) the lowest and the highest corner of the bounding box of each [m]


@dataclass(frozen=True, slots=True, eq=False)
class ForceArrays:
    """Contact forces that balance an assembly, one row per force."""

    lower: tuple[BodyId, ...]  # of k forces: the lower body
    upper: tuple[BodyId, ...]  # the upper body
    points: Array  # (k, 3) points of application [m]
    forces: Array  # (k, 3) of `lower` on `upper` [N]


def bricks_in_poses(
    names: Sequence[BodyId],
    shapes: Sequence[ConvexShape] | ArrayLike,
    masses: ArrayLike,
    positions: ArrayLike,
    orientations: ArrayLike | None = None,
) -> list[Placed]:
    """Return bricks for `add_all` and `would_all`.

    `shapes` are shapes, or (n, 3) lengths, widths and thicknesses of boxes [m], or one (3,) for all; `masses` (n,) or
    one for all [kg]; `positions` (n, 3) of centres of mass [m]; `orientations` (n, 4) unit quaternions x, y, z, w, or
    one (4,) for all, and None for no rotation. Raises ValueError for arrays of other shapes; `add_all` checks the
    values.
    """
    if isinstance(names, str):
        raise TypeError(f"expected a sequence of names, such as ['{short_repr(names)[1:-1]}'], not a string")
    names = listed(names, "names, such as ['a']")
    count = len(names)
    made = _shapes(shapes, count)
    weights = _rows("masses", masses, count, ())
    places = _rows("positions", positions, count, (3,))
    turns = _rows("orientations", IDENTITY if orientations is None else orientations, count, (4,))
    return [
        Placed(Brick(name, shape, float(mass)), Pose(_vector(place), _quaternion(turn)))
        for name, shape, mass, place, turn in zip(names, made, weights, places, turns, strict=True)
    ]


def pose_of(position: ArrayLike, orientation: ArrayLike = IDENTITY) -> Pose:
    """Return a pose from arrays: (3,) of a centre of mass [m], (4,) a unit quaternion x, y, z, w. Raises ValueError."""
    return Pose(
        _vector(_rows("position", position, 1, (3,))[0]), _quaternion(_rows("orientation", orientation, 1, (4,))[0])
    )


def bricks_of(assembly: AssemblyAnswers) -> BrickArrays:
    """Return the poses of all bricks of an assembly. Raises TypeError for anything else."""
    _admit_assembly(assembly)
    placed = list(assembly.bricks.values())
    count = len(placed)
    return BrickArrays(
        tuple(each.brick.id for each in placed),
        np.array([each.pose.position_W for each in placed]).reshape(count, 3),
        np.array([each.pose.orientation for each in placed]).reshape(count, 4),
        np.array([each.brick.mass for each in placed]),
        np.array([bounds_W(each.brick.shape, each.pose) for each in placed]).reshape(count, 2, 3),
    )


def forces_of(assembly: AssemblyAnswers) -> ForceArrays | None:
    """Return the balancing forces of an assembly that stands, as `Assembly.forces`; None if it does not.

    Raises TypeError for anything but an assembly.
    """
    _admit_assembly(assembly)
    forces = assembly.forces()
    if forces is None:
        return None
    rows = [
        (contact.lower, contact.upper, point, np.sum(in_cones, axis=0))
        for contact, at_points in zip(assembly.all_contacts(), forces.of_contacts, strict=True)
        for point, in_cones in zip(contact.points_W, at_points, strict=True)
    ]
    return ForceArrays(
        tuple(row[0] for row in rows),
        tuple(row[1] for row in rows),
        np.array([row[2] for row in rows]).reshape(len(rows), 3),
        np.array([row[3] for row in rows]).reshape(len(rows), 3),
    )


def _admit_assembly(assembly: object) -> None:
    if not isinstance(assembly, AssemblyAnswers):
        raise TypeError(f"expected an Assembly, not {short_repr(assembly)}")


def _shapes(shapes: Sequence[ConvexShape] | ArrayLike, count: int) -> Iterable[ConvexShape]:
    if not isinstance(shapes, Sequence) or not any(hasattr(each, "least_thickness") for each in shapes):
        sizes: ArrayLike = shapes  # type: ignore[assignment]  # as no shape is among them
        return [Box(_vector(size)) for size in _rows("sizes", sizes, count, (3,))]
    if len(shapes) != count:
        raise ValueError(f"there are {count} names but {len(shapes)} shapes; write one shape for each brick")
    return shapes  # type: ignore[return-value]  # `add_all` refuses other types


def _rows(what: str, values: ArrayLike, count: int, shape: tuple[int, ...]) -> Array:
    """Return an array with one row per brick, also if one value is given for all bricks."""
    try:
        rows = np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"{what} must be numbers: {error}") from error
    if rows.shape not in (shape, (count, *shape)):
        row = f"({', '.join(map(str, shape))},)" if shape else "a number"
        whole = f"({', '.join(map(str, (count, *shape)))}{'' if shape else ','})"
        raise ValueError(f"{what} have the array shape {rows.shape}; expected {whole}, or {row} for all bricks")
    return np.broadcast_to(rows, (count, *shape))


def _vector(row: Array) -> Vec3:
    admit_numbers("a row of an array is", row.tolist(), 3, "write finite numbers")
    x, y, z = row.tolist()
    return (x, y, z)


def _quaternion(row: Array) -> Quaternion:
    admit_numbers("a row of an array is", row.tolist(), 4, "write finite numbers")
    x, y, z, w = row.tolist()
    return (x, y, z, w)
