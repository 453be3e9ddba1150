"""Bodies of MJCF and URDF: one shape each, somewhere in the body, which is somewhere in the scene."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stability.model import Quaternion, Vec3
from stackdsl.diagnostics import Span
from stackdsl.importing.load import Exact3, ImportedBox, LoadReading
from stackdsl.importing.measures import FURTHEST, HEAVIEST, ROUGHEST, SHORTEST
from stackdsl.importing.meshes import Mesh, merged, solid_brick

ROUNDED: Final = 1e-9  # of a size: what of a centre of mass, or of a turn [deg], is rounding
DIGITS: Final = 12  # of a metre, or of a degree


@dataclass(frozen=True, slots=True)
class Body:
    """A body of one shape, in SI units; turns are x, y, z, w."""

    name: str
    span: Span
    shape: str  # `box` or `mesh`, or else what it is
    size: Vec3 | None  # of a box
    corners: Sequence[Vec3]  # of a mesh, in the frame of the shape
    faces: Sequence[Sequence[int]]
    mass: Fraction
    place: Vec3  # of the body in the scene
    turn: Quaternion
    shape_place: Vec3  # of the shape in the body
    shape_turn: Quaternion
    centre_of_mass: Vec3  # in the body
    friction: Fraction | None = None  # Coulomb coefficient of its own


def brick_of(reading: LoadReading, body: Body) -> ImportedBox | None:
    """A body as a brick; told and None if it is none."""
    hint = f"if it may be passed over, write ignore: ['{body.name}']"
    if body.shape not in {"box", "mesh"}:
        reading.open(body.span, f"'{body.name}' is a {body.shape}, and a brick is a box or a convex mesh", hint)
        return None
    if not _is_within_reason(reading, body):
        return None
    whole = Rotation.from_quat(body.turn) * Rotation.from_quat(body.shape_turn)
    centre = np.array(body.place) + Rotation.from_quat(body.turn).apply(body.shape_place)
    mass_at = np.array(body.place) + Rotation.from_quat(body.turn).apply(body.centre_of_mass)
    made = (_box if body.size else _solid)(reading, body, whole, centre, mass_at)
    return made and replace(made, friction=body.friction)


def _is_within_reason(reading: LoadReading, body: Body) -> bool:
    """Whether its numbers are such as a brick may have; told if they are not."""
    if not 0 < body.mass <= HEAVIEST:
        reading.wrong(body.span, f"'{body.name}' has a mass of {float(body.mass):g} kg", "write more than zero")
        return False
    if not np.isfinite([*body.turn, *body.shape_turn]).all():
        reading.wrong(body.span, f"'{body.name}' is turned by what is no angle", "write numbers")
        return False
    lengths = np.array([body.place, body.shape_place, body.centre_of_mass, *body.corners])
    if not (np.abs(lengths) <= float(FURTHEST)).all():  # nor is what is no number
        message = f"'{body.name}' is more than 10 km away, or has its mass or a corner there"
        reading.wrong(body.span, message, "mend its numbers, or their unit")
        return False
    if body.friction is not None and not 0 <= body.friction <= ROUGHEST:
        message = f"'{body.name}' has a friction of {float(body.friction):g}"
        reading.wrong(body.span, message, f"write from 0 to {ROUGHEST}")
        return False
    return True


def _box(
    reading: LoadReading, body: Body, whole: Rotation, centre: NDArray[np.float64], mass_at: NDArray[np.float64]
) -> ImportedBox | None:
    assert body.size is not None
    if not SHORTEST <= min(body.size) <= max(body.size) <= FURTHEST:
        reading.wrong(body.span, f"'{body.name}' has sides of {body.size} m", "mend them, or their unit")
        return None
    with warnings.catch_warnings():  # of angles that are not unique; these are as good as others
        warnings.simplefilter("ignore", UserWarning)
        turn = whole.as_euler("xyz", degrees=True)
    heavy = whole.inv().apply(mass_at - centre)
    off = bool(np.abs(heavy).max() > ROUNDED * max(body.size))
    heavy_at = _exact(heavy) if off else None
    return ImportedBox(
        body.name, _exact(body.size), _exact(centre), body.mass, body.span, _exact(turn), heavy_at=heavy_at
    )


def _solid(
    reading: LoadReading, body: Body, whole: Rotation, centre: NDArray[np.float64], mass_at: NDArray[np.float64]
) -> ImportedBox | None:
    corners = [_exact(corner) for corner in centre + whole.apply(np.array(body.corners))]
    places, faces = merged(corners, body.faces)
    return solid_brick(reading, Mesh(body.name, places, faces, body.span), mass=body.mass, heavy_at=_exact(mass_at))


def _exact(parts: Sequence[float] | NDArray[np.float64]) -> Exact3:
    x, y, z = (Fraction(repr(round(float(part), DIGITS))) for part in parts)
    return (x, y, z)
