"""Props: fixed supports that press from below against what is free of a brick's underside, with the friction of bricks.

A prop does not give way, wherever it stands, and stands where no brick of the finished design lies, so that it is in
nobody's way. It cannot pull. What of a face is free need not be convex; it is covered by convex pieces that overlap.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from stability.friction_law import law_of
from stability.geometry.clipping import cut
from stability.geometry.polygons import doubled_area
from stability.geometry.rotations import rotate
from stability.geometry.vectors import add_scaled, cross, dot, scale, subtract, unit
from stability.model import BodyId, Vec3
from stability.shapes.in_pose import corners_W
from stability.statics.assembly import Assembly
from stability.statics.facts import Contact

DOWNWARD = -0.05  # vertical part of the normal of a face from which on it is no wall, so that something can prop it
LEAST_PIECE = 1e-3  # of a face: what is free of it and smaller holds no prop
MOST_PIECES = 12  # of one face, the largest first
PARALLEL = 1.0 - 1e-6  # cosine: a patch with such a normal lies on the face

Flat = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Prop:
    """What may prop one brick."""

    brick: BodyId
    contacts: tuple[Contact, ...]  # with a fixed body; `upper` is the brick


def props_of(design: Assembly) -> dict[BodyId, Prop]:
    """The prop of each brick of a design whose underside is not all covered."""
    found, law = {}, law_of(design.friction)
    for name in sorted(design.bricks):
        body = f"prop under {name}"
        while body in design.bricks:
            body += "'"
        contacts = tuple(
            Contact(body, name, piece, (scale(-1.0, normal),), law.of(name, body))
            for normal, piece in _free(design, name)
        )
        if contacts:
            found[name] = Prop(name, contacts)
    return found


def _free(design: Assembly, name: BodyId) -> Iterator[tuple[Vec3, tuple[Vec3, ...]]]:
    """The normals and corners of convex pieces that cover what is free of the underside of a brick [in W, m]."""
    placed = design.bricks[name]
    corners = corners_W(placed.brick.shape, placed.pose)
    for face in placed.brick.shape.faces:
        normal = rotate(placed.pose.orientation, face.normal)
        if normal[2] > DOWNWARD:
            continue
        border = [corners[index] for index in face.corners]
        origin = border[0]
        along = unit(subtract(border[1], origin))
        across = cross(normal, along)

        def flat(point: Vec3, origin: Vec3 = origin, along: Vec3 = along, across: Vec3 = across) -> Flat:
            away = subtract(point, origin)
            return dot(away, along), dot(away, across)

        whole = [flat(point) for point in border]
        least = LEAST_PIECE * doubled_area(whole)[0]
        pieces = [whole]
        for patch in _covering(design, name, normal):
            pieces = _beside([flat(point) for point in patch], pieces, least)
        for piece in pieces:
            yield normal, tuple(add_scaled(add_scaled(origin, x, along), y, across) for x, y in piece)


def _covering(design: Assembly, name: BodyId, normal: Vec3) -> Iterator[Sequence[Vec3]]:
    """The patches on a face of a brick, by its normal; what lies on top of a flat one takes none of its underside."""
    for contact in design.contacts(name):
        outward = 1.0 if contact.lower == name else -1.0
        on_it = any(outward * dot(n, normal) > PARALLEL for n in contact.normals_W)
        if on_it and len(contact.points_W) > 2:  # noqa: PLR2004 -- a patch has an area
            yield contact.points_W


def _beside(patch: Sequence[Flat], pieces: Sequence[Sequence[Flat]], least: float) -> list[list[Flat]]:
    """Convex pieces that cover what of others lies beside a patch, the largest first, each of some area."""
    if doubled_area(patch)[0] < 0.0:
        patch = patch[::-1]
    found = []
    for piece in pieces:
        for (ax, ay), (bx, by) in zip(patch, [*patch[1:], patch[0]], strict=True):
            outside = [(by - ay) * (x - ax) - (bx - ax) * (y - ay) for x, y in piece]
            kept = cut(piece, outside)
            if len(kept) > 2 and doubled_area(kept)[0] > least:  # noqa: PLR2004 -- a polygon has three
                found.append(kept)
    return sorted(found, key=lambda each: -doubled_area(each)[0])[:MOST_PIECES]
