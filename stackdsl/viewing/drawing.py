"""Draws a scene as SVG shapes, by parallel projection and in painter's order."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Flag, StrEnum, auto
from heapq import heappop, heappush
from html import escape
from itertools import chain, groupby, product
from math import atan2, cos, degrees, floor, hypot, log10, sin
from typing import Final

import numpy as np

from stability.geometry.compound import Compound
from stability.geometry.placed_shape import part_pose
from stability.geometry.polygons import convex_hull
from stability.geometry.round_solid import RoundSolid
from stability.geometry.rows import Array, cross_rows
from stability.geometry.vectors import rotate
from stability.model import BodyId, Brick, ConvexShape, Plane, Pose
from stability.ties import Tie
from stability.work_limit import add_work
from stackdsl.shown_text import visible
from stackdsl.trace import EventKind
from stackdsl.viewing.bores import bore_rims
from stackdsl.viewing.run_view import RunView, ShownProof
from stackdsl.viewing.studs import pitches, studs_of
from stackdsl.viewing.style import token
from stackdsl.viewing.svg import width_of
from stackdsl.viewing.thrust import Thrust

# Views: parallel projections, without perspective.


@dataclass(frozen=True)
class View:
    """A direction of view."""

    name: str
    towards: Array  # (3,) unit vector to the viewer
    right: Array  # (3,) unit vector, to the right on paper
    up: Array  # (3,) unit vector, upwards on paper

    @classmethod
    def of(cls, name: str, towards: tuple[float, float, float], up: tuple[float, float, float]) -> "View":
        """Return the view from a direction, with another one upwards on paper; both of any length."""
        to = np.array(towards) / np.linalg.norm(towards)
        right = np.cross(up, to)
        right /= np.linalg.norm(right)
        return cls(name, to, right, np.cross(to, right))

    @property
    def light(self) -> Array:
        """The direction to the light, in W, unit."""
        light: Array = np.array(LIGHT) @ np.array((self.right, self.up, self.towards))
        return light

    def on_paper(self, points_W: Array) -> Array:
        """Project points (n, 3) in W to (n, 2) on paper, right and up [m]."""
        return points_W @ np.column_stack((self.right, self.up))


VIEWS: Final = {
    view.name: view
    for view in (
        View.of("three-quarter", (0.75, -1.0, 0.55), (0.0, 0.0, 1.0)),
        View.of("front", (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
        View.of("side", (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        View.of("plan", (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    )
}


# Painter's order: solids behind are painted before those in front. The order is exact.
#
# Two convex solids that do not overlap are separated by a plane, and the one on its far side is painted first. Only
# pairs that overlap on paper need this test. If three or more solids cover each other in a cycle, no order of whole
# solids is right; the farthest is painted first.


TOUCHING = 1e-6  # share of a solid's size by which two may overlap and still count as separated
PARALLEL = 1e-6  # sine of the angle below which two edges are parallel
COMPARED, SWEPT = 250.0, 0.3  # units of work for a pair of solids that overlap on paper, and in x alone
FLAT = 1e-9  # cosine deviation below which two directions are equal


@dataclass(frozen=True)
class Solid:
    """The geometry of a placed brick."""

    corners: Array  # (n, 3) in W [m]
    normals: Array  # (faces, 3) in W, unit, outwards
    edges: Array  # (directions, 3) in W, unit
    faces: tuple[tuple[int, ...], ...]  # indices of corners
    is_curved: tuple[bool, ...]  # whether each face stands for a part of a curved surface
    parts: "tuple[Solid, ...]" = ()  # convex ones, of a compound
    studs: tuple[Array, ...] = ()  # (2, n, 3) rings of the foot and the top of each, in W [m]
    bore: tuple[Array, ...] = ()  # (n, 3) rims of its bore at both ends, in W [m]

    @classmethod
    def of(cls, shape: ConvexShape, pose: Pose, pitch: float | None = None) -> "Solid":
        """Return the solid of a shape at a pose; with studs on its upper face if these have a pitch [m]."""
        parts: tuple[Solid, ...] = ()
        if isinstance(shape, Compound):
            parts = tuple(cls.of(part.shape, part_pose(part, pose)) for part in shape.parts)
        corners = np.array([rotate(pose.orientation, corner) for corner in shape.corners]) + pose.position_W
        normals = np.array([rotate(pose.orientation, face.normal) for face in shape.faces])
        edges = np.array([corners[b] - corners[a] for a, b in shape.edges])
        edges /= np.linalg.norm(edges, axis=1, keepdims=True)
        studs = tuple(
            np.array([[rotate(pose.orientation, point) for point in ring] for ring in stud]) + pose.position_W
            for stud in studs_of(shape, pitch)
        )
        curved = tuple(isinstance(shape, RoundSolid) and face not in shape.flat_faces for face in shape.faces)
        faces = tuple(face.corners for face in shape.faces)
        bore = tuple(
            np.array([rotate(pose.orientation, point) for point in rim]) + pose.position_W for rim in bore_rims(shape)
        )
        return cls(corners, normals, _different(edges), faces, curved, parts, studs, bore)

    @property
    def convex_parts(self) -> "tuple[Solid, ...]":
        """The parts of a compound, or the solid itself."""
        return self.parts or (self,)


def painters_order(solids: Sequence[Solid], view: View) -> list[int]:
    """Return the indices of solids in the order in which they are painted. Raises TooMuchWorkError."""
    behind: list[set[int]] = [set() for _ in solids]  # solids to paint before each
    covers: list[list[int]] = [[] for _ in solids]
    for a, b in _on_each_other(solids, view):
        add_work(COMPARED)
        way = _in_front(solids[a], solids[b], view)
        if way:
            first, last = (a, b) if way > 0 else (b, a)
            behind[last].add(first)
            covers[first].append(last)
    return _sorted(behind, covers, [float((solid.corners @ view.towards).mean()) for solid in solids])


def _sorted(behind: list[set[int]], covers: list[list[int]], near: Sequence[float]) -> list[int]:
    """Sort topologically: a solid follows all those behind it; a cycle starts with the farthest."""
    waiting = set(range(len(behind)))
    ready: list[tuple[float, int]] = [(near[place], place) for place in waiting if not behind[place]]
    ready.sort()
    order = []
    while waiting:
        if not ready:
            heappush(ready, min((near[place], place) for place in _ring(behind, waiting)))
        _, place = heappop(ready)
        if place not in waiting:
            continue
        waiting.remove(place)
        order.append(place)
        for other in covers[place]:
            behind[other].discard(place)
            if not behind[other]:
                heappush(ready, (near[other], other))
    return order


def _ring(behind: Sequence[set[int]], waiting: set[int]) -> list[int]:
    """Return a cycle of solids that cover each other; every waiting solid has another one behind it."""
    path = [min(waiting)]
    while True:
        further = min(behind[path[-1]])
        if further in path:
            return path[path.index(further) :]
        path.append(further)


def _on_each_other(solids: Sequence[Solid], view: View) -> Iterator[tuple[int, int]]:
    """Yield pairs whose bounding boxes on paper overlap, by a sweep from left to right."""
    if not solids:
        return
    low = np.array([view.on_paper(solid.corners).min(axis=0) for solid in solids])
    high = np.array([view.on_paper(solid.corners).max(axis=0) for solid in solids])
    slack = TOUCHING * float((high - low).max())
    order = np.argsort(low[:, 0], kind="stable")
    open_now: list[int] = []
    for place in order.tolist():
        add_work(SWEPT * len(open_now))
        open_now = [other for other in open_now if high[other, 0] > low[place, 0] + slack]
        for other in open_now:
            if min(high[other, 1], high[place, 1]) > max(low[other, 1], low[place, 1]) + slack:
                yield other, place
        open_now.append(place)


def _in_front(a: Solid, b: Solid, view: View) -> int:
    """Return 1 if b is in front of a, -1 if a is in front of b, 0 if neither covers the other.

    The decision uses the separating plane with the largest gap, so solids that overlap by rounding still have one.
    """
    slack = TOUCHING * float(np.ptp(a.corners, axis=0).max())
    if _room(a, b, _crossed(np.concatenate((a.edges, b.edges)), view.towards[None, :])).max() >= -slack:
        return 0  # a plane seen edge-on separates them on paper
    normals = np.concatenate((a.normals, -b.normals, _crossed(a.edges, b.edges)))
    room, faces = _room(a, b, normals), normals @ view.towards
    apart = room >= room.max() - slack
    return 1 if faces[np.argmax(np.where(apart, np.abs(faces), -1.0))] > 0.0 else -1


def _room(a: Solid, b: Solid, normals: Array) -> Array:
    """Return the gap between a and b along each direction [m]; negative if they overlap."""
    gap: Array = (b.corners @ normals.T).min(axis=0) - (a.corners @ normals.T).max(axis=0)
    return gap


def _crossed(a: Array, b: Array) -> Array:
    """Return the unit cross products of all pairs of edges, with both signs."""
    crossed = cross_rows(np.repeat(a, len(b), axis=0), np.tile(b, (len(a), 1)))
    length = np.linalg.norm(crossed, axis=1)
    crossed = crossed[length > PARALLEL] / length[length > PARALLEL][:, None]
    return np.concatenate((crossed, -crossed))


def _different(directions: Array) -> Array:
    """Return each direction once, regardless of sign."""
    unique: list[Array] = []
    for direction in directions:
        if not any(abs(abs(float(direction @ other)) - 1.0) < FLAT for other in unique):
            unique.append(direction)
    return np.array(unique)


# A scene on paper: the ground with its grid and shadows, bricks in painter's order, and names on them.


IN_SHADE = -1.0  # cosine to the light of the inside of a bore
FROM_BELOW = -0.1  # cosine below which the studs on a face are hidden by their brick
EDGE_ON = 1e-6  # cosine below which a plane counts as seen edge-on
GRAZING = 0.05  # cosine below which a plane has no grid and no shadows, which would have no end on it
LIGHT = (-0.45, 0.6, 0.66)  # direction to the light: to the right and upwards on paper, and to the viewer; unit
DARKEST = 0.44  # share of its colour that a face turned away from the light has
NO_FILL, DASHES = "none", "4 3"  # of bricks that are not there [px]
SEAM = 0.5  # width of the lines between the faces of a curved surface [px]
STEEPER = 0.5  # factor of the slope of the light along which shadows fall, so that they stay near
THINNEST, THICKEST, OF_BRICK = 0.25, 1.0, 0.06  # outline of bricks [px], and as a share of their least side
NAME_SIZES = (12.0, 10.0)  # of names on bricks, the first that fits [px]
ROOM = (2.0, 1.0)  # beside a name, and above and below it [px]
ROUND = (1.0, 2.0, 5.0)


@dataclass(frozen=True)
class DrawingArea:
    """The part of the plane of projection that is drawn, and its scale."""

    low: Array  # (2,) corner at the bottom left [m]
    scale: float  # [px/m]
    width: float  # [px]
    height: float  # [px]

    def place(self, points: Array) -> Array:
        """Map points (n, 2) of the plane of projection to the paper, from its top left [px]."""
        at = (points - self.low) * self.scale
        return np.column_stack((at[:, 0], self.height - at[:, 1]))


def round_below(value: float) -> float:
    """Return the largest of 1, 2, 5 and their products with powers of ten up to a value."""
    power = 10.0 ** floor(log10(value) + TOUCHING)
    return max(factor * power for factor in ROUND if factor * power <= value * (1.0 + TOUCHING))


def ground_shapes(
    planes: Sequence[Plane], solids: Iterable[Solid], view: View, paper: DrawingArea, grid: float
) -> Iterator[str]:
    """Yield the ground with a grid [m] and the shadows of solids on it, and planes that are seen edge-on."""
    ground, lines = token("ground"), token("grid")
    for plane in planes[:1]:
        normal = np.array(plane.normal_W)
        if normal @ view.towards > EDGE_ON:
            yield f'<rect width="100%" height="100%" fill="{ground}" stroke="none"/>'
        if normal @ view.towards > GRAZING and normal @ view.light > GRAZING:
            yield f'<path d="{_grid(plane, view, paper, grid)}" stroke="{lines}" fill="none"/>'
            shadows = " ".join(_shadow(part, plane, view, paper) for solid in solids for part in solid.convex_parts)
            yield f'<path d="{shadows}" fill="#000" fill-opacity=".13" stroke="none"/>'
    far = 2.0 * (paper.width + paper.height) / paper.scale
    edges = ""
    for plane in planes:
        normal, point = np.array(plane.normal_W), np.array(plane.point_W)
        if abs(normal @ view.towards) <= EDGE_ON:
            along = far * np.cross(normal, view.towards)
            ends = [point - along, point + along, point + along - far * normal, point - along - far * normal]
            band = paper.place(view.on_paper(np.array(ends)))
            edges += _path(band[:2])
            yield f'<path d="{_path(band)}" fill="{ground}" stroke="none"/>'
    if edges:
        yield f'<path d="{edges}" stroke="{token("edge")}" fill="none"/>'


def _grid(plane: Plane, view: View, paper: DrawingArea, step: float) -> str:
    """Return the path of lines on a plane, a step [m] apart along both axes, over the whole paper."""
    point, normal = np.array(plane.point_W), np.array(plane.normal_W)
    along = np.eye(3)[0 if abs(normal[0]) < 1.0 - GRAZING else 1]
    first = along - (along @ normal) * normal
    first /= np.linalg.norm(first)
    axes = np.array((first, np.cross(normal, first)))
    size = np.array((paper.width, paper.height)) / paper.scale
    corners = paper.low + np.array(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))) * size
    seen = corners @ np.array((view.right, view.up))
    seen += ((point - seen) @ normal / (view.towards @ normal))[:, None] * view.towards  # along the view to the plane
    at = (seen - point) @ axes.T / step
    low, high = np.floor(at.min(axis=0)), np.ceil(at.max(axis=0))
    path = ""
    for axis in (0, 1):
        for number in np.arange(low[axis], high[axis] + 1.0):
            ends = np.array((low, high))
            ends[:, axis] = number
            path += _path(paper.place(view.on_paper(point + step * ends @ axes)))[:-1]
    return path


def _shadow(solid: Solid, plane: Plane, view: View, paper: DrawingArea) -> str:
    normal = np.array(plane.normal_W)
    shade = STEEPER * view.light + (1.0 - STEEPER) * (view.light @ normal) * normal
    height = np.maximum((solid.corners - np.array(plane.point_W)) @ normal, 0.0)
    fallen = solid.corners - np.outer(height / (shade @ normal), shade)
    outline = convex_hull([(float(x), float(y)) for x, y in paper.place(view.on_paper(fallen))])
    return _path(np.array(outline))


def _path(points: Array) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points.tolist()) + "Z"


@dataclass(frozen=True)
class Face:
    """A face of a brick on paper that looks at the viewer."""

    brick: BodyId
    turn: int  # of its brick in painter's order
    outline: Array  # (n, 2) [px]
    fill: str  # colour; `none` for a brick that is not there, of which only an outline is drawn
    is_curved: bool = False  # part of a curved surface, whose edges are not drawn

    @property
    def area(self) -> float:
        """The area [px^2]."""
        x, y = self.outline.T
        return abs(float(x @ np.roll(y, 1) - y @ np.roll(x, 1))) / 2.0


def faces_of(
    solids: Mapping[BodyId, Solid], colours: Mapping[BodyId, str], view: View, paper: DrawingArea
) -> list[Face]:
    """Return the faces of solids that a viewer sees or that others cover, in painter's order."""
    parts = [(name, part) for name, solid in solids.items() for part in solid.convex_parts]
    faces = []
    for turn, place in enumerate(painters_order([part for _, part in parts], view)):
        name, solid = parts[place]
        colour = colours[name]
        on_paper = paper.place(view.on_paper(solid.corners))
        faces += [
            Face(name, turn, on_paper[list(face)], _lit(colour, float(normal @ view.light)), curved)
            for normal, face, curved in zip(solid.normals, solid.faces, solid.is_curved, strict=True)
            if normal @ view.towards > EDGE_ON
        ]
        faces += [
            Face(name, turn, paper.place(outline), _lit(colour, float(normal @ view.light)))
            for outline, normal in _studs(solid, view, [part for _, part in parts])
        ]
        faces += [Face(name, turn, paper.place(hole), _lit(colour, IN_SHADE)) for hole in _hole(solid, view)]
    return faces


def _hole(solid: Solid, view: View) -> Iterator[Array]:
    """Yield the outline in the view of the end of a bore that a viewer sees [m]."""
    for near, far in (solid.bore, solid.bore[::-1]) if solid.bore else ():
        out = near.mean(axis=0) - far.mean(axis=0)
        if out @ view.towards > EDGE_ON * np.linalg.norm(out):
            yield view.on_paper(near)


def _studs(solid: Solid, view: View, others: Sequence[Solid]) -> Iterator[tuple[Array, Array]]:
    """Yield outlines in the view [m] and normals of the studs of a solid, the farthest first: the side, and the top.

    Studs inside of other solids are left out.
    """
    if not solid.studs:
        return
    middles = np.array([stud.mean(axis=(0, 1)) for stud in solid.studs])
    inside = np.zeros(len(middles), dtype=bool)
    for other in others:
        heights = np.sum(other.normals * other.corners[[face[0] for face in other.faces]], axis=1)
        inside |= (middles @ other.normals.T < heights).all(axis=1)
    free = [stud for stud, hidden in zip(solid.studs, inside, strict=True) if not hidden]
    for foot, top in sorted(free, key=lambda stud: float(stud[0].mean(axis=0) @ view.towards)):
        up = (top[0] - foot[0]) / np.linalg.norm(top[0] - foot[0])
        if up @ view.towards < FROM_BELOW:
            return
        on_paper = view.on_paper(np.concatenate((foot, top)))
        side = view.towards - (view.towards @ up) * up
        yield np.array(convex_hull([(float(x), float(y)) for x, y in on_paper])), side
        if up @ view.towards > EDGE_ON:
            yield on_paper[len(foot) :], up


def brick_shapes(faces: Iterable[Face], rim: float) -> Iterator[str]:
    """Yield the faces of bricks, grouped by brick with its name as title; `rim` is the width of outlines [px]."""
    yield f'<g stroke="{token("outline")}" stroke-width="{rim:.2f}" stroke-linejoin="round">'
    for (_, name), group in groupby(faces, key=lambda face: (face.turn, face.brick)):
        own = sorted(group, key=lambda face: not face.is_curved)  # the edges of flat ends are drawn over the side
        curved = np.concatenate([np.zeros((0, 2)), *(face.outline for face in own if face.is_curved)])
        shapes = ""
        if len(curved):
            around = np.array(convex_hull([(float(x), float(y)) for x, y in curved]))
            shapes = f'<path d="{_path(around)}" {_style(replace(own[0], is_curved=False))}/>'
        shapes += "".join(f'<path d="{_path(face.outline)}" {_style(face)}/>' for face in own)
        yield f"<g><title>{escape(visible(name))}</title>{shapes}</g>"
    yield "</g>"


def _style(face: Face) -> str:
    if face.fill == NO_FILL and not face.is_curved:
        return f'fill="{NO_FILL}" stroke="{token("ink-2")}" stroke-width="1" stroke-dasharray="{DASHES}"'
    # The seams of a curved surface are closed by its own colour.
    return f'fill="{face.fill}" stroke="{face.fill}" stroke-width="{SEAM}"' if face.is_curved else f'fill="{face.fill}"'


def rim_of(bricks: Iterable[Brick], scale: float) -> float:
    """Return the width of outlines [px] at a scale [px/m], which is less for tiny bricks."""
    least = min((float(np.ptp(np.array(brick.shape.corners), axis=0).min()) for brick in bricks), default=1.0)
    return min(THICKEST, max(THINNEST, OF_BRICK * least * scale))


def _lit(colour: str, cosine: float) -> str:
    """Return the colour of a face by the cosine of the angle between its normal and the light."""
    if colour == NO_FILL:
        return colour
    light = DARKEST + (1.0 - DARKEST) * (1.0 + cosine) / 2.0
    return "#" + "".join(f"{round(light * part):02x}" for part in _channels(colour))


def _channels(colour: str) -> list[int]:
    return [int(colour[at : at + 2], 16) for at in (1, 3, 5)]


def names_on(faces: Sequence[Face], covers: Sequence[Array] = ()) -> dict[BodyId, str]:
    """Return a text for each brick with room for its name on a face, where neither bricks nor outlines cover it."""
    faces = [face for face in faces if face.fill != NO_FILL]
    lows = np.array([face.outline.min(axis=0) for face in faces]).reshape(-1, 2)
    highs = np.array([face.outline.max(axis=0) for face in faces]).reshape(-1, 2)
    turns = np.array([face.turn for face in faces])
    texts: dict[BodyId, str] = {}
    for face in sorted(faces, key=lambda face: -face.area):
        if face.brick in texts:
            continue
        for size, angle in product(NAME_SIZES, (0.0, _slope(face.outline))):
            box = _box(face, size, angle)
            near = (lows < box.max(axis=0)).all(axis=1) & (highs > box.min(axis=0)).all(axis=1)
            bricks = (faces[at].outline for at in np.flatnonzero(near & (turns > face.turn)).tolist())
            if _holds(face.outline, box) and all(_apart(outline, box) for outline in chain(covers, bricks)):
                texts[face.brick] = _name(face, size, angle)
                break
    return texts


def _middle(face: Face) -> Array:
    middle: Array = face.outline.mean(axis=0)
    return middle


def _slope(outline: Array) -> float:
    """Return the angle of the longest edge, from which a text is never upside down [rad]."""
    edges = np.roll(outline, -1, axis=0) - outline
    x, y = edges[np.argmax(np.linalg.norm(edges, axis=1))].tolist()
    return atan2(y, x) if x > 0.0 or (x == 0.0 and y < 0.0) else atan2(-y, -x)


def _box(face: Face, size: float, angle: float) -> Array:
    """Return the corners (4, 2) of the box around a name [px]."""
    half = np.array((width_of(visible(face.brick), size) / 2.0, 0.36 * size)) + ROOM
    corners = half * np.array(((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)))
    turned = np.array(((cos(angle), sin(angle)), (-sin(angle), cos(angle))))
    box: Array = _middle(face) + corners @ turned
    return box


def _holds(outline: Array, points: Array) -> bool:
    """Return whether all points lie inside a convex outline."""
    edges = np.roll(outline, -1, axis=0) - outline
    sides = np.cross(edges[:, None, :], points[None, :, :] - outline[:, None, :])
    return bool((sides >= 0.0).all() or (sides <= 0.0).all())


def _apart(one: Array, other: Array) -> bool:
    """Return whether a line separates two convex outlines."""
    for outline in (one, other):
        x, y = (np.roll(outline, -1, axis=0) - outline).T
        normals = np.stack((-y, x))
        a, b = one @ normals, other @ normals
        if ((a.max(axis=0) <= b.min(axis=0)) | (b.max(axis=0) <= a.min(axis=0))).any():
            return True
    return False


def _name(face: Face, size: float, angle: float) -> str:
    x, y = _middle(face).tolist()
    red, green, blue = _channels(face.fill)
    ink = "#000000" if 0.3 * red + 0.59 * green + 0.11 * blue > 110.0 else "#ffffff"  # noqa: PLR2004
    turn = f' transform="rotate({degrees(angle):.1f} {x:.1f} {y:.1f})"' if angle else ""
    text = escape(visible(face.brick))
    place = f'x="{x:.1f}" y="{y + 0.36 * size:.1f}" font-size="{size:g}" text-anchor="middle"{turn}'
    return f'<text class="name" {place} fill="{ink}">{text}</text>'


# Forces as arrows, and the bars that give lengths and forces a scale.


RAMP = ("f1", "f2", "f3", "f4", "f5")
LONGEST = 0.4  # length of the arrow of the largest force, in longest sides of the bricks
SMALLEST = 0.01  # share of the largest force below which no arrow is drawn
MERGED = 6  # decimal places of a position [m] that tell forces apart
SHORTEST = 3.0  # [px] least length of an arrow; a force along the view has none


@dataclass(frozen=True)
class Arrow:
    """A force on paper: its tip is the contact point on which it acts."""

    tail: Array  # (2,) in the plane of projection [m]
    tip: Array  # (2,) [m]
    share: float  # of the largest force


def forces_on_paper(proof: ShownProof, view: View) -> list[tuple[Array, Array]]:
    """Return places (2,) in the plane of projection [m] and forces (2,) in it [N].

    Forces that act at one place on paper, such as on the front and the back edge of a brick, are added up.
    """
    sums: dict[tuple[float, float], Array] = {}
    for contact in proof.contacts:
        places = view.on_paper(np.array(contact.points_W)).round(MERGED)
        for place, force in zip(places.tolist(), view.on_paper(np.array(contact.forces_W)), strict=True):
            sums[tuple(place)] = sums.get(tuple(place), 0.0) + force
    return [(np.array(place), force) for place, force in sums.items()]


@dataclass(frozen=True)
class ForceScale:
    """The length of arrows."""

    most: float  # the largest force on paper [N]
    longest: float  # length of its arrow [m]

    @classmethod
    def of(cls, proofs: Sequence[tuple[ShownProof, View]], bricks: Sequence[Brick]) -> "ForceScale | None":
        """Return the common scale of some proofs and their views, in proportion to the bricks; None without forces."""
        forces = [force for proof, view in proofs for _, force in forces_on_paper(proof, view)]
        most = max((float(np.linalg.norm(force)) for force in forces), default=0.0)
        return cls(most, LONGEST * max(brick.shape.length for brick in bricks)) if most > 0.0 else None

    def arrows(self, proof: ShownProof, view: View) -> list[Arrow]:
        """Return the forces of a proof, the smallest first."""
        forces = [(float(np.linalg.norm(force)) / self.most, at, force) for at, force in forces_on_paper(proof, view)]
        arrows = [Arrow(at - force * self.longest / self.most, at, share) for share, at, force in forces]
        return sorted((arrow for arrow in arrows if arrow.share > SMALLEST), key=lambda arrow: arrow.share)


def load_scale(proofs: Sequence[tuple[ShownProof, View]], bricks: Sequence[Brick]) -> ForceScale | None:
    """Return the common scale of the loads of some proofs, whose sizes differ from those of contact forces."""
    forces = [view.on_paper(np.array([load.force_W]))[0] for proof, view in proofs for load in proof.loads]
    most = max((float(np.linalg.norm(force)) for force in forces), default=0.0)
    return ForceScale(most, LONGEST * max(brick.shape.length for brick in bricks)) if most > 0.0 else None


def load_arrows(proof: ShownProof, view: View, scale: ForceScale) -> list[Arrow]:
    """Return the loads on bricks, each with its tip where it acts."""
    arrows = []
    for load in proof.loads:
        (tip,), (force,) = view.on_paper(np.array([load.point_W])), view.on_paper(np.array([load.force_W]))
        share = float(np.linalg.norm(force)) / scale.most
        arrows.append(Arrow(tip - force * scale.longest / scale.most, tip, share))
    return [arrow for arrow in arrows if arrow.share > SMALLEST]


TIE = 2.5  # [px] width of a tie
THRUST = 2.5  # [px] width of a line of thrust
HINGE = 4.0  # [px] radius of a hinge


def thrust_shapes(thrust: Thrust, view: View, paper: DrawingArea) -> Iterator[str]:
    """Yield the line of thrust, and its hinges."""
    line, halo = token("fail"), token("halo")
    ends = [paper.place(view.on_paper(np.array((each.begin_W, each.end_W)))).tolist() for each in thrust.lines]
    path = "".join(f"M{x:.1f} {y:.1f}L{u:.1f} {v:.1f}" for (x, y), (u, v) in ends)
    for colour, wide in ((halo, THRUST + 2.0), (line, THRUST)):
        yield f'<path class="thrust" d="{path}" stroke="{colour}" stroke-width="{wide:g}" stroke-linecap="round"/>'
    for _, point in thrust.hinges:
        ((x, y),) = paper.place(view.on_paper(np.array([point]))).tolist()
        yield hinge_shape(x, y)


def tie_shapes(ties: Iterable[Tie], view: View, paper: DrawingArea) -> Iterator[str]:
    """Yield the courses of ties."""
    for tie in ties:
        corners = paper.place(view.on_paper(np.array(tie.course_W))).tolist()
        path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in corners)
        for colour, wide in ((token("halo"), TIE + 2.0), (token("accent"), TIE)):
            yield (
                f'<path class="tie" d="{path}" fill="none" stroke="{colour}" stroke-width="{wide:g}" '
                'stroke-linejoin="round" stroke-linecap="round"/>'
            )


def hinge_shape(x: float, y: float) -> str:
    """Return a hinge at a place on paper [px]."""
    return (
        f'<circle class="hinge" cx="{x:.1f}" cy="{y:.1f}" r="{HINGE:g}" fill="{token("scene")}" '
        f'stroke="{token("fail")}" stroke-width="2"/>'
    )


def arrow_shapes(arrows: Iterable[Arrow], paper: DrawingArea, colour: str = "") -> Iterator[str]:
    """Yield arrows with a halo; a larger force is thicker and darker, unless all have one `colour`."""
    for arrow in arrows:
        tail, tip = paper.place(np.array((arrow.tail, arrow.tip))).tolist()
        yield from arrow_shape(tail, tip, arrow.share, colour)


def arrow_shape(tail: Sequence[float], tip: Sequence[float], share: float, colour: str = "") -> Iterator[str]:
    """Yield an arrow between two places on paper [px]; nothing if it is too short to be seen."""
    (x1, y1), (x2, y2) = tail, tip
    length = hypot(x2 - x1, y2 - y1)
    if length < SHORTEST:
        return
    x, y = (x2 - x1) / length, (y2 - y1) / length
    wide, head = 1.5 + 2.0 * share, min(0.6 * length, 5.0 + 6.0 * share)
    colour, halo = colour or token(RAMP[min(len(RAMP) - 1, int(share * len(RAMP)))]), token("halo")
    sides = [(x2 - head * (x + side * 0.45 * y), y2 - head * (y - side * 0.45 * x)) for side in (-1.0, 1.0)]
    line = f"M{x1:.1f} {y1:.1f}L{x2 - 0.8 * head * x:.1f} {y2 - 0.8 * head * y:.1f}"
    tips = _path(np.array(((x2, y2), *sides)))
    yield f'<path class="force" d="{line}{tips}" stroke="{halo}" stroke-width="{wide + 2.0:.1f}" fill="{halo}"/>'
    yield f'<path d="{line}" stroke="{colour}" stroke-width="{wide:.1f}"/>'
    yield f'<path d="{tips}" fill="{colour}"/>'


@dataclass(frozen=True)
class ScaleBar:
    """A bar of a round length along x, or along y if x is seen end-on.

    A view that is not along an axis shortens lengths, and the bar with them.
    """

    length: float  # [m]
    way: Array  # (2,) from its begin to its end on paper, downwards positive [px]
    text: str

    @classmethod
    def of(cls, view: View, scale: float, longest: float) -> "ScaleBar":
        """Return the longest bar up to a length on paper [px], at a scale [px/m]."""
        along = 0 if abs(view.towards[0]) < 1.0 - EDGE_ON else 1
        way = view.on_paper(np.eye(3)[along : along + 1])[0]
        shown = float(np.linalg.norm(way))
        length = round_below(longest / scale / shown)
        more = "" if abs(shown - 1.0) < EDGE_ON else f" along {'xy'[along]}"
        return cls(length, length * scale * way * (1.0, -1.0), f"{length_text(length)}{more}")

    def shapes(self, x: float, y: float) -> Iterator[str]:
        """Yield the bar with its ends from a place on [px]."""
        to_x, to_y = x + self.way[0], y + self.way[1]
        ends = f"M{x:.1f} {y - 5.0:.1f}v10M{to_x:.1f} {to_y - 5.0:.1f}v10"
        line = f"{ends}M{x:.1f} {y:.1f}L{to_x:.1f} {to_y:.1f}"
        yield f'<path d="{line}" stroke="{token("halo")}" stroke-width="4"/>'
        yield f'<path d="{line}" stroke="{token("ink")}" stroke-width="1.5"/>'


def length_text(length: float) -> str:
    """Return a round length [m] in the unit that gives the shortest number."""
    factor, unit = (1e3, "mm") if length < 0.1 - TOUCHING else (1e2, "cm") if length < 1.0 - TOUCHING else (1.0, "m")
    return f"{length * factor:g} {unit}"


def force_text(force: float) -> str:
    """Return a round force [N]."""
    factor, unit = (1e3, "mN") if force < 0.1 else (1.0, "N") if force < 1e3 else (1e-3, "kN")  # noqa: PLR2004
    return f"{float(f'{force * factor:.3g}'):g} {unit}"


# A run at one time.


class State(StrEnum):
    """State of a brick, as legends name it."""

    STANDS = "stands"
    MOVES = "moves"
    RIDES = "rides on another"
    LEFT = "has fallen"
    THROWN = "thrown or dropped"

    @property
    def colour(self) -> str:
        """The colour of such bricks."""
        return token(TOKENS[self])


TOKENS: Final = {
    State.STANDS: "wood",
    State.MOVES: "moves",
    State.RIDES: "rides",
    State.LEFT: "left",
    State.THROWN: "thrown",
}
AROUND, STILL = 0.05, 1e-4  # a simulated brick stands if it moves by less [m] in this time before and after [s]


class Overlay(Flag):
    """Marks that are drawn over bricks."""

    FORCES = auto()  # of the proof that holds
    NAMES = auto()
    THRUST = auto()  # line of thrust of these forces, and hinges
    JOINTS = auto()  # colours by the use of joints, in place of those of states


@dataclass(frozen=True)
class JointUse:
    """The largest share of strength that a joint of a brick uses at the load factor, as legends name it."""

    text: str
    colour: str


USED: Final = ("#f2efe6", "#cfe0e8", "#9fc5da", "#629fc4", "#2f74a8")  # by the share of strength
NO_JOINT: Final = "no joint"


def joint_uses(run: RunView) -> dict[str, JointUse]:
    """Return the entries of the legend, by the order of their text."""
    each = 100 // len(USED)
    steps = [JointUse(f"{each * n} to {each * (n + 1)} % of strength used", colour) for n, colour in enumerate(USED)]
    factor = "" if run.limit is None else f" at {run.limit.factor:.4g} times the weight"
    first = JointUse(f"a joint gives way first{factor}", token("left"))
    return {use.text: use for use in (*steps, first, JointUse(NO_JOINT, token("edge")))}


def joint_uses_at(run: RunView, time: float) -> dict[BodyId, JointUse]:
    """Return the use of the joints of each brick that is present at a time [s]; empty without a load factor."""
    if run.limit is None:
        return {}
    uses = list(joint_uses(run).values())
    most: dict[BodyId, int] = {}
    for joint in run.limit.joints:
        step = len(USED) if joint.yields else min(int(joint.used * len(USED)), len(USED) - 1)
        for body in (joint.lower, joint.upper):
            most[body] = max(most.get(body, 0), step)
    return {name: uses[most.get(name, len(USED) + 1)] for name in present_at(run, time)}


NOTHING: Final = Overlay(0)


@dataclass(frozen=True)
class Frame:
    """The view and time of a drawing."""

    view: View
    time: float  # [s]
    overlays: Overlay = NOTHING


def solids_at(run: RunView, time: float) -> dict[BodyId, Solid]:
    """Return the bricks that are present at a time [s]."""
    poses, studs = run.recording.at(time), pitches(run.timeline.world.joints)
    solids = {}
    for number, brick in enumerate(run.recording.bricks):
        if not np.isnan(poses.positions[number, 0]):
            x, y, z = poses.positions[number].tolist()
            pose = Pose((x, y, z), tuple(poses.orientations[number].tolist()))
            solids[brick.id] = Solid.of(brick.shape, pose, studs.get(brick.id))
    return solids


def states_at(run: RunView, time: float) -> dict[BodyId, State]:
    """Return the states of the bricks that are present at a time [s]."""
    states: dict[BodyId, State] = {}
    for event in run.trace.events:
        if event.time > time:
            break
        if event.kind is EventKind.FROZEN:
            states |= dict.fromkeys(event.bricks, State.STANDS)
        elif event.kind is EventKind.WOKEN:
            states |= dict.fromkeys(event.bricks, State.MOVES) | dict.fromkeys(event.riding, State.RIDES)
    freezes = any(event.kind is EventKind.FROZEN for event in run.trace.events)
    moving = set() if freezes else moving_at(run, time)
    for name in present_at(run, time):
        states.setdefault(name, State.MOVES if freezes or name in moving else State.STANDS)
    states |= {
        placement.brick.id: State.THROWN
        for placement in run.timeline.placements
        if placement.hits and placement.brick.id in states
    }
    left = {name for name, track in run.trace.tracks.items() if track.left_at is not None and time >= track.left_at}
    return {name: State.LEFT if name in left else states[name] for name in present_at(run, time)}


def present_at(run: RunView, time: float) -> list[BodyId]:
    """Return the bricks that are present at a time [s]."""
    there = ~np.isnan(run.recording.at(time).positions[:, 0])
    return [brick.id for brick, is_there in zip(run.recording.bricks, there, strict=True) if is_there]


def moving_at(run: RunView, time: float) -> set[BodyId]:
    """Return the bricks that move notably around a time [s]."""
    before, after = (run.recording.at(time + off).positions for off in (-AROUND, AROUND))
    ways = np.nan_to_num(np.linalg.norm(after - before, axis=1))
    return {brick.id for brick, way in zip(run.recording.bricks, ways, strict=True) if way > STILL}


def pulled_out_at(run: RunView, time: float) -> dict[BodyId, Solid]:
    """Return the bricks that are pulled out by a time [s], where they were, while all others stand."""
    recording = run.recording
    removed = {brick.id: brick for brick, at in zip(recording.bricks, recording.removed_at, strict=True) if at <= time}
    if any(state is not State.STANDS for state in states_at(run, time).values()):
        return {}
    rests = {name: run.trace.tracks[name].rest for name in removed}
    studs = pitches(run.timeline.world.joints)
    return {
        name: Solid.of(removed[name].shape, pose, studs.get(name)) for name, pose in rests.items() if pose is not None
    }


def proof_at(run: RunView, time: float) -> ShownProof | None:
    """Return the proof that holds at a time [s]."""
    return next((proof for proof in run.proofs.standing if proof.begin <= time < proof.end), None)
