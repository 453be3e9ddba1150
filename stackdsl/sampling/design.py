"""What is built, brick by brick in the order of the hands: what each belongs on, and what it may meet."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import acos, hypot, inf

from stability.friction_law import GivenFriction
from stability.geometry.rotations import about, inverse, multiply, rotate
from stability.geometry.touching import gap_bridged, reach_between
from stability.model import GROUND, IDENTITY, BodyId, Plane, Pose, Quaternion
from stability.shapes.box import Box
from stability.shapes.in_pose import corners_W
from stability.statics.assembly import Assembly
from stability.statics.contacts.solids import BoxSolid
from stability.statics.contacts.touch import solid
from stability.statics.facts import Contact, Placed, Tolerances
from stability.statics.load_core import carries_upright
from stability.statics.samples.flat_bricks import Array, Mask
from stability.statics.structure import Structure
from stackdsl.timeline import Jitter, Placement, Timeline


@dataclass(frozen=True, slots=True)
class Part:
    """One brick as it is designed, in the frame of the scene: level ground at z = 0."""

    number: int  # in the order of the hands
    placed: Placed
    flat: tuple[float, float, float, float] | None  # in plan: direction of the first side, half lengths [m]; else None
    low: float  # of its lowest and highest point [m]
    high: float
    radius: float  # that it fits in, in plan [m]
    thickness: float  # [m]
    rests_on: tuple[Contact, ...]  # the contacts that carry it
    jitter: Jitter | None

    @property
    def name(self) -> BodyId:
        """What the brick is called."""
        return self.placed.brick.id

    def reach(self, other: "Part") -> float:
        """From which the two still touch [m]."""
        return reach_between(self.thickness, other.thickness)


@dataclass(frozen=True, slots=True)
class Unit:
    """Bricks that hands set down as one: alone, or two that lean on each other."""

    parts: tuple[Part, ...]
    supports: tuple[int, ...]  # the bricks that it belongs on
    grounded: bool  # whether it belongs on the ground as well, or stands free
    centre: tuple[float, float]  # the mean of its bricks, in plan [m]

    @property
    def jitter(self) -> Jitter | None:
        """The errors that it is set down with."""
        return self.parts[0].jitter


@dataclass(frozen=True, slots=True)
class Moment:
    """What comes at one time, and is judged together."""

    units: tuple[Unit, ...]
    level: int  # under construction


@dataclass(frozen=True)
class Design:
    """A structure to be built by hands, unit by unit."""

    moments: tuple[Moment, ...]
    planes: tuple[Plane, ...]  # in the frame of the scene
    planes_W: tuple[Plane, ...]
    tilt: Quaternion  # from the frame of the scene to W
    friction: GivenFriction
    gravity: float
    tolerances: Tolerances

    def is_bridged(self, gap: Array, reach: float) -> Mask:
        """Whether what lies so far above something [m] touches it, with the reach of the two [m]."""
        touches: Mask = gap <= gap_bridged(reach, 1.0, self.tolerances.within)
        return touches

    def assembly(self) -> Assembly:
        """An empty site."""
        return Assembly(self.planes_W, self.friction, self.gravity, self.tolerances, overlap=inf)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """All bricks in the order of the hands."""
        return tuple(part for moment in self.moments for unit in moment.units for part in unit.parts)

    @property
    def is_flat(self) -> bool:
        """Whether all are boxes that lie flat on what is level."""
        return self.tilt == IDENTITY and all(part.flat is not None for part in self.parts)


def design_of(timeline: Timeline) -> Design:
    """The design of what a timeline sets down."""
    world = timeline.world
    tilt = _tilt(world.planes[0])
    back = inverse(tilt)
    planes = tuple(_turned(plane, back) for plane in world.planes)
    structure = Structure(planes, (), world.friction, world.gravity, world.tolerances)
    moments, count = [], 0
    for moment in timeline.as_set_down().moments():
        assert isinstance(moment, tuple)  # only what is set down may be sampled
        level = next((each.level for each in reversed(moment) if each.builds), moment[-1].level)
        units = []
        for group in _upwards(_units(moment)):
            unit = _unit(group, timeline.jitter, structure, count, back)
            count += len(unit.parts)
            units.append(unit)
        moments.append(Moment(tuple(units), level))
    return Design(tuple(moments), planes, world.planes, tilt, world.friction, world.gravity, world.tolerances)


def _units(moment: Sequence[Placement]) -> list[list[Placement]]:
    units: list[list[Placement]] = []
    for placement in moment:
        if placement.together and units:
            units[-1].append(placement)
        else:
            units.append([placement])
    return units


def _upwards(units: Sequence[list[Placement]]) -> list[list[Placement]]:
    """What comes at one time, from the lowest on: neither names nor the author's order decide what is set on what."""
    return sorted(units, key=lambda unit: min((p.pose.position_W[2], *p.pose.position_W[:2]) for p in unit))


def _unit(
    group: Sequence[Placement], jitter: Mapping[BodyId, Jitter], structure: Structure, first: int, back: Quaternion
) -> Unit:
    parts = []
    for number, placement in enumerate(group, start=first):
        pose = placement.pose if back == IDENTITY else _pose_turned(placement.pose, back)
        placed = Placed(placement.brick, pose)
        structure.put(placed)
        parts.append(_part(number, placed, structure, jitter.get(placement.brick.id)))
    own = {part.name for part in parts}
    lower = {contact.lower for part in parts for contact in part.rests_on} - own
    on = tuple(number for number, name in enumerate(structure.bricks) if name in lower)
    x, y = (sum(part.placed.pose.position_W[axis] for part in parts) / len(parts) for axis in (0, 1))
    return Unit(tuple(parts), on, not on or GROUND in lower, (x, y))


def _part(number: int, placed: Placed, structure: Structure, jitter: Jitter | None) -> Part:
    own = solid(placed)
    flat = own.plan if isinstance(own, BoxSolid) and isinstance(placed.brick.shape, Box) else None
    name, (x, y, _) = placed.brick.id, placed.pose.position_W
    corners = corners_W(placed.brick.shape, placed.pose)
    radius = max(hypot(cx - x, cy - y) for cx, cy, _ in corners)
    carried = tuple(c for c in structure.touching[name].values() if c.upper == name and carries_upright(c))
    low, high = min(z for _, _, z in corners), max(z for _, _, z in corners)
    return Part(number, placed, flat, low, high, radius, placed.brick.shape.least_thickness, carried, jitter)


def _tilt(ground: Plane) -> Quaternion:
    """The turn that leans the upright as the ground's normal leans."""
    x, y, z = ground.normal_W
    lean = hypot(x, y)
    return IDENTITY if lean == 0.0 else about((-y / lean, x / lean, 0.0), acos(max(-1.0, min(1.0, z))))


def _pose_turned(pose: Pose, turn: Quaternion) -> Pose:
    return Pose(rotate(turn, pose.position_W), multiply(turn, pose.orientation))


def _turned(plane: Plane, turn: Quaternion) -> Plane:
    if turn in (IDENTITY, inverse(IDENTITY)):
        return plane
    return Plane(plane.id, rotate(turn, plane.point_W), rotate(turn, plane.normal_W), plane.friction)
