"""Joints between bricks: mortar and glue, tape and magnets, studs. They pull, and hold sideways, up to a bound.

A joint adds contact points with bounded forces to a contact of two bodies, whose own points push and rub as without the
joint. The bounds are those of limit analysis: a joint that yields keeps its force.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from itertools import pairwise
from math import hypot, inf
from typing import Final, Self

from stability.contact_law import ContactLaw, Coulomb, MohrCoulomb
from stability.geometry.box import box_of
from stability.geometry.polygons import between
from stability.geometry.vectors import (
    SHORTEST,
    add,
    add_scaled,
    admit_number,
    body_axes,
    cross,
    dot,
    rotate,
    scale,
    short_repr,
    subtract,
)
from stability.model import BodyId, Quaternion, Vec3
from stability.problem import Contact, Placed

EQUAL: Final = 1e-9  # share of an area: cells that differ by less have the same law
ALIGNED: Final = 0.05  # of the pitch: the grids of two boxes may differ by this at a stud
UPRIGHT: Final = 0.999  # cosine of the largest angle between the studs of a box and the normal of a contact
ASIDE: Final = 0.045  # the same of the smallest angle at which a contact is one of two side faces
CORNERS_OF_A_FACE: Final = 3
PAIR: Final = 2
FEW: Final = 1000  # studs of a box: more take too much memory for arrays of all contacts
ROUND_CELLS: Final = 64  # of a bond on a full circle
STRONGEST: Final = 1e60  # [Pa, N]


class Joint(ABC):
    """Strength of a joint, independent of the contact that it holds."""

    @property
    def sheds(self) -> bool:
        """Return whether it sheds its force when it yields."""
        return False

    ductile: float  # [m] by which its bodies may move apart while it keeps its bound; 0: it opens as soon as it yields

    @abstractmethod
    def points(self, contact: Contact, bodies: Sequence[Placed]) -> Mapping[ContactLaw, Sequence[Vec3]]:
        """Return the points of the joint at a contact with a single normal, by their law.

        `bodies` are the boxes of the contact, the upper one first; a plane is not among them.
        """

    @abstractmethod
    def times(self, factor: float) -> Self:
        """Return the same joint with its strength multiplied by a factor."""

    def dry_contact(self, contact: Contact, _bodies: Sequence[Placed]) -> Contact:
        """Return a contact to which the joint adds no points."""
        return contact


@dataclass(frozen=True, slots=True)
class Bond(Joint):
    """Mortar or glue: a strength per area. Friction adds the coefficient of the two bodies times the pressure."""

    tension: float  # [Pa]
    cohesion: float  # [Pa] of shear without pressure
    shear: float = inf  # [Pa] at any pressure
    brittle: bool = False  # whether it sheds its force when it yields
    ductile: float = field(default=0.0, kw_only=True)

    @property
    def sheds(self) -> bool:
        """Return whether it is brittle."""
        return self.brittle

    @property
    def strengths(self) -> tuple[float, float, float]:
        """Return tension, cohesion and shear [Pa]."""
        return self.tension, self.cohesion, self.shear

    def points(self, contact: Contact, bodies: Sequence[Placed]) -> Mapping[ContactLaw, Sequence[Vec3]]:
        """Return the centres of cells around the corners of the patch; the law holds for each whole cell.

        Uniform stresses in the cells are within the strength, so these forces are a bound from below. For a motion that
        opens the patch it is the exact one: an opening speed is linear, and its mean is that at the centre of a cell.
        """
        corners, patch = contact.points_W, contact.patch
        if patch is not None:
            patch = replace(patch, angles=()).with_sides(ROUND_CELLS)
            corners = patch.placed(patch.inner)
        cells = list(_cells(corners, contact.normals_W[0]))
        areas = [area for _, area in cells]
        if patch is not None and sum(areas) > 0.0:  # the cells share the area of the whole patch
            areas = [area * patch.area / sum(areas) for area in areas]
        if areas and max(areas) - min(areas) <= EQUAL * max(areas):
            areas = [sum(areas) / len(areas)] * len(areas)
        by_law: dict[ContactLaw, list[Vec3]] = {}
        for (centre, _), area in zip(cells, areas, strict=True):
            strength = (self.tension * area, self.cohesion * area, self.shear * area)
            by_law.setdefault(MohrCoulomb(contact.law.friction, *strength), []).append(centre)
        return by_law

    def times(self, factor: float) -> Self:
        """Return the bond with all strengths multiplied by a factor."""
        return replace(self, tension=factor * self.tension, cohesion=factor * self.cohesion, shear=factor * self.shear)


@dataclass(frozen=True, slots=True)
class Pull(Joint):
    """Magnets, tape or Velcro: each corner of the contact is pressed by a force, against which it opens."""

    force: float  # [N]
    ductile: float = field(default=0.0, kw_only=True)

    def points(self, contact: Contact, bodies: Sequence[Placed]) -> Mapping[ContactLaw, Sequence[Vec3]]:
        """Return the points of the contact, with friction as if the force pressed them."""
        friction = contact.law.friction
        return {MohrCoulomb(friction, self.force, friction * self.force): contact.points_W}

    def times(self, factor: float) -> Self:
        """Return the pull multiplied by a factor."""
        return replace(self, force=factor * self.force)


@dataclass(frozen=True, slots=True)
class Studs(Joint):
    """Studs of toy bricks on a square grid that is centred on each box: each holds as soon as both grids meet there."""

    pitch: float  # [m]
    pull: float  # [N] of one stud
    shear: float  # [N] of one stud, in any direction
    narrow_pull: float | None = None  # [N] of one stud under a brick that is one stud wide; None if it is `pull`
    smooth: frozenset[BodyId] = field(default=frozenset(), kw_only=True)  # boxes without studs on their upper faces
    ductile: float = field(default=0.0, kw_only=True)

    def points(self, contact: Contact, bodies: Sequence[Placed]) -> Mapping[ContactLaw, Sequence[Vec3]]:
        """Return four points of each stud, a quarter of the pitch beside its centre, which share its strength.

        Four points are symmetric, so a mirrored structure has the same verdict.
        """
        grids = self._grids(contact, bodies, {body.brick.id: _grid_of(body, self.pitch) for body in bodies})
        if not grids:
            return {}
        upper, *below = grids
        middles = upper.middles() if not below else upper.common(below[0])
        normal_W = contact.normals_W[0]
        points = upper.quarters(middles, dot(normal_W, contact.points_W[0]), normal_W)
        return {self._law(contact, grids): points} if points else {}

    def points_of_many(
        self, asked: Sequence[tuple[Contact, Sequence[Placed]]]
    ) -> Iterator[Mapping[ContactLaw, Sequence[Vec3]]]:
        """Yield the points of the studs of each contact, as `points`, by arrays."""
        each = {body.brick.id: body for _, bodies in asked for body in bodies}
        known = {name: _grid_of(body, self.pitch) for name, body in each.items()}
        grids = [self._grids(contact, bodies, known) for contact, bodies in asked]
        pairs = [i for i, own in enumerate(grids) if len(own) == PAIR and own[0].counts[0] * own[0].counts[1] <= FEW]
        normals_W = [asked[i][0].normals_W[0] for i in pairs]
        heights = [dot(normal_W, asked[i][0].points_W[0]) for i, normal_W in zip(pairs, normals_W, strict=True)]
        found = dict(zip(pairs, _common_points([grids[i] for i in pairs], heights, normals_W), strict=True))
        for i, (contact, bodies) in enumerate(asked):
            if i not in found:
                yield self.points(contact, bodies)
            else:
                yield {self._law(contact, grids[i]): found[i]} if found[i] else {}

    def _grids(
        self, contact: Contact, bodies: Sequence[Placed], known: Mapping[BodyId, "_Grid | None"]
    ) -> Sequence["_Grid"]:
        """Return the grids of the boxes of a contact, the upper one first; none if no studs meet."""
        normal_W = contact.normals_W[0]
        grids = [grid for placed in bodies if (grid := known[placed.brick.id]) is not None]
        ups = [dot(grid.up_W, normal_W) for grid in grids]
        if not ups or len(ups) < len(bodies) or min(map(abs, ups)) < UPRIGHT or min(ups) * max(ups) < 0.0:
            return ()
        is_smooth = len(bodies) == PAIR and bodies[1 if ups[0] > 0.0 else 0].brick.id in self.smooth
        return () if is_smooth else grids

    def _law(self, contact: Contact, grids: Sequence["_Grid"]) -> MohrCoulomb:
        """Return the law of the points between two grids, the upper one first, or of one grid and a plane."""
        points_up = dot(grids[0].up_W, contact.normals_W[0]) > 0.0
        return self._narrow if min(grids[0 if points_up else -1].counts) == 1 else self._wide

    @property
    def _wide(self) -> MohrCoulomb:
        """Return the law of a point."""
        return _stud_law(self.pull, self.shear)

    @property
    def _narrow(self) -> MohrCoulomb:
        """Return the law of a point under a brick that is one stud wide."""
        return _stud_law(self.pull if self.narrow_pull is None else self.narrow_pull, self.shear)

    def times(self, factor: float) -> Self:
        """Return the studs with their pull and shear multiplied by a factor."""
        narrow = None if self.narrow_pull is None else factor * self.narrow_pull
        return replace(self, pull=factor * self.pull, shear=factor * self.shear, narrow_pull=narrow)

    def dry_contact(self, contact: Contact, bodies: Sequence[Placed]) -> Contact:
        """Return the contact of two side faces as a push at half of its height, without friction.

        Real bricks are a tenth of a millimetre apart and push where they happen to touch, so neither their corners nor
        friction are relied on.
        """
        normal_W = contact.normals_W[0]
        if len(contact.normals_W) != 1 or len(bodies) != PAIR:
            return contact
        if any(abs(dot(body_axes(placed.pose.orientation)[2], normal_W)) > ASIDE for placed in bodies):
            return contact
        up_W = body_axes(bodies[0].pose.orientation)[2]
        heights = [dot(up_W, point) for point in contact.points_W]
        middle = 0.5 * (min(heights) + max(heights))
        across_W = cross(up_W, normal_W)
        moved = (
            add_scaled(point, middle - height, up_W) for point, height in zip(contact.points_W, heights, strict=True)
        )
        ordered = sorted(moved, key=lambda point: dot(across_W, point))
        return replace(contact, points_W=(ordered[0], ordered[-1]), law=Coulomb(0.0), gaps=())


def on_one_grid(one: Placed, other: Placed, pitch: float) -> bool:
    """Return whether the studs of two boxes are on one grid, seen along those of the first one."""
    (x_W, y_W, up_W), turned_W = (body_axes(placed.pose.orientation) for placed in (one, other))
    grids = [grid for placed in (one, other) if (grid := _grid_of(placed, pitch))]
    if len(grids) < PAIR or abs(dot(grids[1].up_W, up_W)) < UPRIGHT:
        return False
    if max(abs(dot(turned_W[0], x_W)), abs(dot(turned_W[0], y_W))) < UPRIGHT:
        return False
    apart = subtract(grids[1].first_W, grids[0].first_W)
    steps = [dot(axis, apart) / pitch for axis in (x_W, y_W)]
    return all(abs(step - round(step)) <= ALIGNED for step in steps)


def studs_meet(one: Placed, other: Placed, pitch: float) -> bool:
    """Return whether one of two boxes that touch fits onto the studs of the other.

    True also for boxes beside one another, whose studs do not touch.
    """
    apart = subtract(other.pose.position_W, one.pose.position_W)
    is_beside = abs(dot(body_axes(one.pose.orientation)[2], apart)) < ALIGNED * pitch
    return is_beside or on_one_grid(one, other, pitch)


@lru_cache(maxsize=64)
def _stud_law(pull: float, shear: float) -> MohrCoulomb:
    """Return the law of one of the four points of a stud."""
    return MohrCoulomb(0.0, pull / 4.0, shear / 4.0)


@dataclass(frozen=True, slots=True)
class _Grid:
    """Square grid of the studs of a box."""

    first_W: Vec3  # the middle of the first cell [m]
    steps_W: tuple[Vec3, Vec3]  # from cell to cell [m]
    quarters_W: Sequence[Vec3]  # from the middle of a cell to its points [m]
    up_W: Vec3  # unit, along the studs
    counts: tuple[int, int]
    pitch: float  # [m]

    def middles(self) -> Iterator[Vec3]:
        """Yield the middles of all cells [m]."""
        for i in range(self.counts[0]):
            row = add_scaled(self.first_W, i, self.steps_W[0])
            for j in range(self.counts[1]):
                yield add_scaled(row, j, self.steps_W[1])

    def common(self, other: "_Grid") -> Iterator[Vec3]:
        """Yield the middles of those cells that meet the middle of a cell of the other grid, seen along the studs."""
        square, (rows, columns) = other.pitch * other.pitch, other.counts
        along, across = other.steps_W
        (ax, ay, az), (bx, by, bz), (fx, fy, fz) = along, across, other.first_W
        for middle in self.middles():
            x, y, z = middle[0] - fx, middle[1] - fy, middle[2] - fz
            row, column = (x * ax + y * ay + z * az) / square, (x * bx + y * by + z * bz) / square
            i, j = round(row), round(column)
            if 0 <= i < rows and 0 <= j < columns and hypot(row - i, column - j) <= ALIGNED:
                yield middle

    def quarters(self, middles: Iterable[Vec3], height: float, normal_W: Vec3) -> Sequence[Vec3]:
        """Return the four points of each cell, a quarter of the pitch beside its middle, at a height [m]."""
        points = []
        nx, ny, nz = normal_W
        for x, y, z in middles:
            rise = height - (nx * x + ny * y + nz * z)
            at_x, at_y, at_z = x + rise * nx, y + rise * ny, z + rise * nz
            points += [(at_x + a, at_y + b, at_z + c) for a, b, c in self.quarters_W]
        return points


def _common_points(
    grids: Sequence[Sequence[_Grid]], heights: Sequence[float], normals_W: Sequence[Vec3]
) -> Sequence[Sequence[Vec3]]:
    """Return for each pair of grids the points of the cells of the first that meet one of the second.

    The digits are those of `common` and `quarters`.
    """
    if not grids:
        return ()
    import numpy as np  # noqa: PLC0415 -- most scenes have no studs

    of_pairs = np.array(
        [(*grid.first_W, *grid.steps_W[0], *grid.steps_W[1], *grid.counts) for pair in grids for grid in pair]
    ).reshape(-1, 2, 11)
    cells = (of_pairs[:, 0, 9] * of_pairs[:, 0, 10]).astype(int)
    which = np.repeat(np.arange(len(grids)), cells)
    (ux, uy, uz, ax, ay, az, bx, by, bz, _, columns), lower = of_pairs[which].transpose(1, 2, 0)
    i, j = np.divmod(np.arange(len(which)) - np.repeat(np.cumsum(cells) - cells, cells), columns)
    x, y, z = ux + i * ax + j * bx, uy + i * ay + j * by, uz + i * az + j * bz
    fx, fy, fz, ax, ay, az, bx, by, bz, lines, columns = lower
    square = grids[0][1].pitch * grids[0][1].pitch
    ahead = x - fx, y - fy, z - fz
    row = (ahead[0] * ax + ahead[1] * ay + ahead[2] * az) / square
    column = (ahead[0] * bx + ahead[1] * by + ahead[2] * bz) / square
    i, j = np.rint(row), np.rint(column)
    meets = (i >= 0) & (i < lines) & (j >= 0) & (j < columns) & (np.hypot(row - i, column - j) <= ALIGNED)
    x, y, z, which = x[meets], y[meets], z[meets], which[meets]
    nx, ny, nz = np.array(normals_W)[which].T
    rise = np.array(heights)[which] - (nx * x + ny * y + nz * z)
    at_W = np.stack([x + rise * nx, y + rise * ny, z + rise * nz], axis=1)
    quarters = np.array([upper.quarters_W for upper, _ in grids])[which]
    points = list(map(tuple, (at_W[:, None] + quarters).reshape(-1, 3).tolist()))
    ends = (len(grids[0][0].quarters_W) * np.cumsum(np.bincount(which, minlength=len(grids)))).tolist()
    return [points[first:last] for first, last in zip([0, *ends], ends, strict=False)]


def _grid_of(placed: Placed, pitch: float) -> _Grid | None:
    """Return the grid of the studs of a box; None if the brick is no box, or too small."""
    box = box_of(placed.brick.shape)
    turned = None if box is None else _turned_grid(box[0].size, box[1], placed.pose.orientation, pitch)
    if turned is None:
        return None
    middle_W, (along_W, across_W), grid = turned
    first_W = add(add(add(placed.pose.position_W, middle_W), along_W), across_W)
    return _Grid(first_W, grid.steps_W, grid.quarters_W, grid.up_W, grid.counts, pitch)


@lru_cache(maxsize=256)  # each box has several contacts, and many are turned alike
def _turned_grid(
    size: Vec3, middle: Vec3, orientation: Quaternion, pitch: float
) -> tuple[Vec3, tuple[Vec3, Vec3], _Grid] | None:
    """Return the way from the position of a box to its middle, two from there to the first cell, and a grid."""
    axes_W = body_axes(orientation)
    counts = round(size[0] / pitch), round(size[1] / pitch)
    if 0 in counts:
        return None
    ways = [scale(-0.5 * (count - 1) * pitch, axis_W) for axis_W, count in zip(axes_W, counts, strict=False)]
    steps = along_W, across_W = scale(pitch, axes_W[0]), scale(pitch, axes_W[1])
    quarters = [add(scale(i, along_W), scale(j, across_W)) for i in (-0.25, 0.25) for j in (-0.25, 0.25)]
    grid = _Grid((0.0, 0.0, 0.0), steps, quarters, axes_W[2], counts, pitch)
    return rotate(orientation, middle), (ways[0], ways[1]), grid


def _cells(corners: Sequence[Vec3], normal: Vec3) -> Iterator[tuple[Vec3, float]]:
    """Yield the centre and the area of the part of a convex patch around each corner; nothing for a line or a point.

    Lines from the centroid to the middles of the edges divide the patch.
    """
    triangles = [(corners[0], one, other) for one, other in pairwise(corners[1:])]
    pieces = [_triangle(triangle, normal) for triangle in triangles]
    if not sum(area for _, area in pieces) > 0.0:
        return
    middle, _ = _joined(pieces)
    for number, corner in enumerate(corners):
        before = between(corners[number - 1], corner, 0.5)
        after = between(corner, corners[(number + 1) % len(corners)], 0.5)
        yield _joined([_triangle((middle, before, corner), normal), _triangle((middle, corner, after), normal)])


def _triangle(corners: tuple[Vec3, Vec3, Vec3], normal: Vec3) -> tuple[Vec3, float]:
    """Return the centre and the area of a triangle."""
    a, b, c = corners
    return scale(1.0 / 3.0, add(add(a, b), c)), 0.5 * abs(dot(cross(subtract(b, a), subtract(c, a)), normal))


def _joined(pieces: Sequence[tuple[Vec3, float]]) -> tuple[Vec3, float]:
    """Return the centre and the area of several pieces together."""
    area = sum(area for _, area in pieces)
    centre = (0.0, 0.0, 0.0)
    for own, share in pieces:
        centre = add_scaled(centre, share / area if area > 0.0 else 1.0 / len(pieces), own)
    return centre, area


@dataclass(frozen=True, slots=True)
class JointRule:
    """Joint between each body of one set and each of another."""

    joint: Joint | None  # None for dry contacts, whatever later rules say
    between: tuple[Collection[BodyId], Collection[BodyId]]

    def holds(self, one: BodyId, other: BodyId) -> bool:
        """Return whether the rule is about these two bodies."""
        a, b = self.between
        return (one in a and other in b) or (other in a and one in b)


@dataclass(frozen=True, slots=True)
class Joints:
    """Joints of a structure. The first rule about a pair counts; a pair without a rule is dry.

    Joints are made when bricks are set down. A brick that has moved has only those joints that have held since.
    """

    rules: tuple[JointRule, ...] = ()
    moved: Collection[BodyId] = frozenset()  # bricks that have moved
    held: Collection[frozenset[BodyId]] = frozenset()  # pairs of bodies whose joint has held while they moved

    def of(self, one: BodyId, other: BodyId) -> Joint | None:
        """Return the joint of two bodies; None for a dry contact."""
        if (one in self.moved or other in self.moved) and frozenset((one, other)) not in self.held:
            return None
        return next((rule.joint for rule in self.rules if rule.holds(one, other)), None)

    def dry_contact(self, contact: Contact, bodies: Mapping[BodyId, Placed]) -> Contact:
        """Return a contact of two bodies to which joints add no points. `bodies` holds the bricks."""
        joint = self.of(contact.lower, contact.upper)
        return contact if joint is None else joint.dry_contact(contact, _held(contact, bodies))

    def times(self, factor: float) -> "Joints":
        """Return the same joints with their strength multiplied by a factor."""
        return self._with(lambda joint: joint and joint.times(factor))

    def without_brittle(self) -> "Joints":
        """Return the joints that keep their force when they yield; the others are dry contacts."""
        return self._with(lambda joint: None if joint is not None and joint.sheds else joint)

    def _with(self, change: Callable[[Joint | None], Joint | None]) -> "Joints":
        return replace(self, rules=tuple(replace(rule, joint=change(rule.joint)) for rule in self.rules))

    @property
    def are_brittle(self) -> bool:
        """Return whether some joints shed their force when they yield."""
        return any(rule.joint is not None and rule.joint.sheds for rule in self.rules)

    def contacts(self, contact: Contact, bodies: Mapping[BodyId, Placed]) -> tuple[Contact, ...]:
        """Return the contacts that a joint adds to a contact of two bodies, one for each of its laws.

        A joint needs a face: it adds nothing where an edge or a corner touches. `bodies` holds the bricks.
        """
        joint = self.of(contact.lower, contact.upper)
        if joint is None or not _is_face(contact):
            return ()
        return _added(joint, contact, joint.points(contact, _held(contact, bodies)))

    def joined(
        self, contacts: Sequence[Contact], bodies: Mapping[BodyId, Placed]
    ) -> Iterator[tuple[Contact, tuple[Contact, ...]]]:
        """Yield each contact as the joints leave it, and the contacts that they add to it: the same, but faster."""
        joints = [self.of(contact.lower, contact.upper) for contact in contacts]
        points: dict[int, Mapping[ContactLaw, Sequence[Vec3]]] = {}
        for studs in {joint for joint in joints if isinstance(joint, Studs)}:
            own = [i for i, joint in enumerate(joints) if joint == studs and _is_face(contacts[i])]
            asked = [(contacts[i], _held(contacts[i], bodies)) for i in own]
            points |= dict(zip(own, studs.points_of_many(asked), strict=True))
        for i, (contact, joint) in enumerate(zip(contacts, joints, strict=True)):
            if joint is None:
                yield contact, ()
                continue
            held = _held(contact, bodies)
            added: tuple[Contact, ...] = ()
            if _is_face(contact):
                added = _added(joint, contact, points[i] if i in points else joint.points(contact, held))
            yield (contact if added else joint.dry_contact(contact, held)), added


def _is_face(contact: Contact) -> bool:
    return len(contact.normals_W) == 1 and len(contact.points_W) >= CORNERS_OF_A_FACE


def _held(contact: Contact, bodies: Mapping[BodyId, Placed]) -> list[Placed]:
    """Return the boxes of a contact, the upper one first."""
    return [bodies[name] for name in (contact.upper, contact.lower) if name in bodies]


def _added(joint: Joint, contact: Contact, points: Mapping[ContactLaw, Sequence[Vec3]]) -> tuple[Contact, ...]:
    brittle = joint.strengths if isinstance(joint, Bond) and joint.brittle else None
    return tuple(
        Contact(contact.lower, contact.upper, tuple(own), contact.normals_W, law, brittle=brittle)
        for law, own in points.items()
    )


DRY = Joints()


def admit_joints(joints: object) -> None:
    """Raise ValueError for an invalid strength or size of a joint, TypeError for anything but joints."""
    if not isinstance(joints, Joints):
        raise TypeError(f"expected Joints(...), not {short_repr(joints)}")
    for rule in joints.rules:
        if not isinstance(rule, JointRule) or not isinstance(rule.joint, Bond | Pull | Studs | None):
            raise TypeError(f"expected JointRule(Bond(...), (names, names)), not {short_repr(rule)}")
        if rule.joint is not None:
            for each in fields(rule.joint):
                number = getattr(rule.joint, each.name)
                if not (each.name == "narrow_pull" and number is None) and each.name not in {"brittle", "smooth"}:
                    _admit(rule.joint, each.name, number)


def _admit(joint: Joint, name: str, number: float) -> None:
    what, least = f"the {name} of the {type(joint).__name__} is", SHORTEST if name == "pitch" else 0.0
    admit_number(what, number, "write a number of at least 0")
    if not (least <= number <= STRONGEST or (isinstance(joint, Bond) and name == "shear" and number == inf)):
        raise ValueError(f"{what} {short_repr(number)}; write a number from {least:g} to {STRONGEST:g}")
