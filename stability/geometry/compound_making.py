"""Construction of compounds from convex parts, with their mass properties."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from stability.geometry.box import Box
from stability.geometry.compound import MOST_PARTS, Compound, Part
from stability.geometry.convex_solid import ConvexSolid, NotASolidError
from stability.geometry.placed_shape import bodies_apart, in_place
from stability.geometry.vectors import add, body_axes, dot, multiply, norm, principal_axes, rotate, scale, subtract
from stability.model import IDENTITY, ConvexShape, Face, Pose, Quaternion, Vec3

# Share of the least thickness: parts this close touch, and may overlap by this much. Files have six decimals.
SEAM: Final = 1e-4
ROUNDED: Final = 1e-5  # share of the extent of the body: the same for parts that are slivers
ALIGNED: Final = 1e-12  # share of the moments: smaller products of inertia are rounding


@dataclass(frozen=True, slots=True)
class FramedCompound:
    """Compound with the position of its centre of mass in the frame of its input."""

    shape: Compound
    centre_of_mass: Vec3  # in the frame of the input, whose axes are the body axes [m]


def compound(
    parts: Iterable[tuple[ConvexShape, Pose]], centre_of_mass: Vec3 | None = None, seam: float = 0.0
) -> FramedCompound:
    """Join convex parts of equal density at poses in one frame to a rigid body.

    `centre_of_mass` is in that frame; the default is that of uniform density. Parts that overlap, or are apart, by at
    most `seam` [m] or `SEAM` touch. Raises NotASolidError for parts that overlap, parts that touch no other part, too
    many parts, and a centre of mass outside the hull of all parts.
    """
    placed = [(shape, place) for shape, place in parts]
    if not 1 <= len(placed) <= MOST_PARTS:
        raise NotASolidError(
            f"the body has {len(placed)} parts", f"write 1 to {MOST_PARTS} parts, and simplify a body that has more"
        )
    for number, (shape, _) in enumerate(placed):
        if not isinstance(shape, Box | ConvexSolid):
            raise NotASolidError(f"part {number + 1} is neither a box nor a convex solid", "divide it", number)
    _admit_joined(placed, seam)
    volumes = [shape.volume for shape, _ in placed]
    total = sum(volumes)
    centroid = (0.0, 0.0, 0.0)
    for (_, place), volume in zip(placed, volumes, strict=True):
        centroid = add(centroid, scale(volume / total, place.position_W))
    centre = centroid if centre_of_mass is None else centre_of_mass
    moved = tuple(Part(shape, Pose(subtract(p.position_W, centre), p.orientation)) for shape, p in placed)
    made = _made(moved, volumes, subtract(centroid, centre))
    if centre_of_mass is not None:
        _admit_inside(made)
    return FramedCompound(made, centre)


def _made(parts: tuple[Part, ...], volumes: Sequence[float], centroid: Vec3) -> Compound:
    corners: list[Vec3] = []
    edges: list[tuple[int, int]] = []
    faces: list[Face] = []
    for part in parts:
        first, turn = len(corners), part.place.orientation
        corners += [_placed(corner, part.place) for corner in part.shape.corners]
        edges += [(first + start, first + end) for start, end in part.shape.edges]
        faces += [
            Face(_turned(face.normal, turn), tuple(first + corner for corner in face.corners))
            for face in part.shape.faces
        ]
    moments, axes = _principal(parts, volumes, centroid)
    spans = [max(along) - min(along) for along in zip(*corners, strict=True)]
    return Compound(
        parts,
        moments,
        axes,
        tuple(corners),
        tuple(edges),
        tuple(faces),
        sum(volumes),
        min(part.shape.least_thickness for part in parts),
        max(spans),
        max(map(norm, corners)),
    )


def _placed(point: Vec3, place: Pose) -> Vec3:
    return add(place.position_W, _turned(point, place.orientation))


def _turned(vector: Vec3, turn: Quaternion) -> Vec3:
    return vector if turn == IDENTITY else rotate(turn, vector)


def _principal(parts: Sequence[Part], volumes: Sequence[float], centroid: Vec3) -> tuple[Vec3, Quaternion]:
    """Return the principal moments about the centroid at a mass of 1, by the parallel axis theorem, and their axes."""
    tensor = [[0.0] * 3 for _ in range(3)]
    total = sum(volumes)
    for part, volume in zip(parts, volumes, strict=True):
        share = volume / total
        moments = part.shape.moments(share)
        axes = body_axes(multiply(part.place.orientation, part.shape.principal_axes))
        arm = subtract(part.place.position_W, centroid)
        for i in range(3):
            for j in range(3):
                own = sum(moment * axis[i] * axis[j] for moment, axis in zip(moments, axes, strict=True))
                about = share * ((dot(arm, arm) if i == j else 0.0) - arm[i] * arm[j])
                tensor[i][j] += own + about
    across = max(abs(tensor[0][1]), abs(tensor[0][2]), abs(tensor[1][2]))
    if across <= ALIGNED * (tensor[0][0] + tensor[1][1] + tensor[2][2]):
        return (tensor[0][0], tensor[1][1], tensor[2][2]), IDENTITY
    for i, j in combinations(range(3), 2):  # restore the symmetry that rounding breaks
        tensor[i][j] = tensor[j][i] = 0.5 * (tensor[i][j] + tensor[j][i])
    return principal_axes(tensor)


def _admit_joined(placed: Sequence[tuple[ConvexShape, Pose]], least: float) -> None:
    """Raise NotASolidError unless the parts touch, directly or through others, and do not overlap."""
    bodies = [in_place(shape, place) for shape, place in placed]
    lows, highs = zip(*((body.low_W, body.high_W) for body in bodies), strict=True)
    extent = max(
        max(high) - min(low) for low, high in zip(zip(*lows, strict=True), zip(*highs, strict=True), strict=True)
    )
    rounding = max(least, ROUNDED * extent)
    of = list(range(len(bodies)))  # the lowest part that each is known to be joined with
    for one, other in combinations(range(len(bodies)), 2):
        seam = max(rounding, SEAM * min(placed[one][0].least_thickness, placed[other][0].least_thickness))
        if any(
            low > high + seam
            for a, b in ((bodies[one], bodies[other]), (bodies[other], bodies[one]))
            for low, high in zip(a.low_W, b.high_W, strict=True)
        ):
            continue
        gap = bodies_apart(bodies[one], bodies[other]).gap
        if gap < -seam:
            raise NotASolidError(
                f"parts {one + 1} and {other + 1} overlap by {-1000.0 * gap:.3g} mm",
                "shorten one of them, so that they touch without overlap",
                other,
            )
        if gap <= seam:
            low, high = sorted((of[one], of[other]))
            of = [low if root == high else root for root in of]
    for number, root in enumerate(of):
        if root != 0:
            raise NotASolidError(
                f"part {number + 1} does not touch the other parts", "move it, or write it as another brick", number
            )


def _admit_inside(made: Compound) -> None:
    """Raise NotASolidError if the centre of mass, the origin, lies outside the hull of a compound."""
    import numpy as np  # noqa: PLC0415 -- few bodies need the hull
    from scipy.spatial import ConvexHull  # noqa: PLC0415

    hull = ConvexHull(np.array(made.corners) / made.length)
    if float(hull.equations[:, 3].max()) >= 0.0:
        raise NotASolidError("the centre of mass lies outside the body", "write a point within the hull of its parts")
