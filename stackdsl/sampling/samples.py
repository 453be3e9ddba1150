"""Draws samples of a scenario: placement errors, uncertain variables, counter-based random numbers."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from itertools import chain
from math import acos, hypot, inf
from typing import Final

import numpy as np
from scipy.special import ndtri

from stability.analysis.sampled_columns import Mask
from stability.contact_law import GivenFriction
from stability.contacts.bodies import BoxSolid, solid
from stability.geometry.box import Box
from stability.geometry.box_distance import gap_bridged, reach_between
from stability.geometry.placed_shape import bounds_W, corners_W
from stability.geometry.round_solid import RoundSolid, is_straight
from stability.geometry.rows import Array
from stability.geometry.vectors import about, inverse, multiply, rotate
from stability.joints import DRY, Joints
from stability.model import GROUND, IDENTITY, BodyId, ConvexShape, Plane, Pose, Quaternion
from stability.problem import Contact, Placed, Tolerances
from stability.statics.assembly import Assembly
from stability.statics.load_core import carries_upright
from stability.statics.structure import Structure
from stackdsl.compiler.compile import compile_timeline
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.distributions import Distribution, Pick, middle
from stackdsl.language.validation import validate
from stackdsl.language.variants import Variant, diagnostics_of, resampled
from stackdsl.language.yaml.source import Plain
from stackdsl.timeline import ErrorSpread, Jitter, Placement, Timeline

# The build plan: bricks in order of placement, each with its supports.


@dataclass(frozen=True, slots=True)
class DesignedBrick:
    """One brick of the design, in the frame of the scene, where the ground is level at z = 0."""

    number: int  # in order of placement
    placed: Placed
    flat: tuple[float, float, float, float] | None  # direction of its first side in plan, half lengths [m]; or tilted
    disc: float | None  # radius of a cylinder that stands upright [m]
    low: float  # height of its lowest point [m]
    high: float  # height of its highest point [m]
    radius: float  # of a bounding circle in plan [m]
    thickness: float  # [m]
    rests_on: tuple[Contact, ...]  # contacts with its supports
    jitter: Jitter | None

    @property
    def name(self) -> BodyId:
        """The name of the brick."""
        return self.placed.brick.id

    def reach(self, other: "DesignedBrick") -> float:
        """Return the largest gap at which two bricks touch [m]."""
        return reach_between(self.thickness, other.thickness)


@dataclass(frozen=True, slots=True)
class Unit:
    """Bricks that are set down together: a single one, or two that lean on each other."""

    parts: tuple[DesignedBrick, ...]
    supports: tuple[int, ...]  # numbers of the bricks that carry it
    grounded: bool  # whether it rests on the ground (too), or has no support
    centre: tuple[float, float]  # the mean of its bricks, in plan [m]

    @property
    def jitter(self) -> Jitter | None:
        """The placement errors of the unit."""
        return self.parts[0].jitter


@dataclass(frozen=True, slots=True)
class BuildStage:
    """Units that are placed at one time and judged together."""

    units: tuple[Unit, ...]
    level: int  # under construction


@dataclass(frozen=True)
class BuildPlan:
    """A design as a sequence of units."""

    moments: tuple[BuildStage, ...]
    planes: tuple[Plane, ...]  # in the frame of the scene
    planes_W: tuple[Plane, ...]
    tilt: Quaternion  # from the frame of the scene to W
    friction: GivenFriction
    gravity: float
    tolerances: Tolerances
    joints: Joints = DRY

    def is_bridged(self, gap: Array, reach: float) -> Mask:
        """Return whether a brick touches its support across a gap [m], given the reach of the two [m]."""
        touches: Mask = gap <= gap_bridged(reach, 1.0, self.tolerances.within)
        return touches

    def assembly(self) -> Assembly:
        """Return an assembly without bricks."""
        site = self.planes_W, self.friction, self.gravity, self.tolerances
        return Assembly(*site, overlap=inf, joints=self.joints)

    @cached_property
    def parts(self) -> tuple[DesignedBrick, ...]:
        """All bricks in order of placement."""
        return tuple(part for moment in self.moments for unit in moment.units for part in unit.parts)

    @property
    def is_flat(self) -> bool:
        """True if the ground is level, and all bricks are boxes that lie flat and have no joints."""
        return self.tilt == IDENTITY and not self.joints.rules and all(part.flat is not None for part in self.parts)


def build_plan_of(timeline: Timeline) -> BuildPlan:
    """Return the build plan of a timeline."""
    world = timeline.world
    tilt = _tilt(world.planes[0])
    back = inverse(tilt)
    planes = tuple(_turned(plane, back) for plane in world.planes)
    structure = Structure(planes, (), world.friction, world.gravity, world.tolerances)
    moments, count = [], 0
    for moment in timeline.as_set_down().moments():
        assert isinstance(moment, tuple)  # validation allows samples only of scenarios that just set bricks down
        level = next((each.level for each in reversed(moment) if each.builds), moment[-1].level)
        units = []
        for group in _upwards(_units(moment)):
            unit = _unit(group, timeline.jitter, structure, count, back)
            count += len(unit.parts)
            units.append(unit)
        moments.append(BuildStage(tuple(units), level))
    site = world.friction, world.gravity, world.tolerances, world.joints
    return BuildPlan(tuple(moments), planes, world.planes, tilt, *site)


def _units(moment: Sequence[Placement]) -> list[list[Placement]]:
    units: list[list[Placement]] = []
    for placement in moment:
        if placement.together and units:
            units[-1].append(placement)
        else:
            units.append([placement])
    return units


def _upwards(units: Sequence[list[Placement]]) -> list[list[Placement]]:
    """Sort the units of one time by height, so that each comes after its supports, whatever the order in the file."""
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


UPRIGHT: Final = 1.0 - 1e-12  # least vertical component of an axis


def _part(number: int, placed: Placed, structure: Structure, jitter: Jitter | None) -> DesignedBrick:
    own = solid(placed)
    flat = own.plan if isinstance(own, BoxSolid) and isinstance(placed.brick.shape, Box) else None
    name, (x, y, _) = placed.brick.id, placed.pose.position_W
    shape = placed.brick.shape
    disc, corners = _upright_radius(shape, placed.pose), corners_W(shape, placed.pose)
    radius = max(hypot(cx - x, cy - y) for cx, cy, _ in corners)
    if isinstance(shape, RoundSolid):
        radius = shape.bounding_radius
    carried = tuple(c for c in chain(*structure.touching[name].values()) if c.upper == name and carries_upright(c))
    (_, _, low), (_, _, high) = bounds_W(shape, placed.pose)
    return DesignedBrick(number, placed, flat, disc, low, high, radius, shape.least_thickness, carried, jitter)


def _upright_radius(shape: ConvexShape, pose: Pose) -> float | None:
    """Return the radius of a cylinder or pipe that stands upright [m]; None for other shapes and poses."""
    if not is_straight(shape) or shape.rounding or any(shape.centre_of_mass[:2]):
        return None
    return shape.widest if abs(rotate(pose.orientation, (0.0, 0.0, 1.0))[2]) > UPRIGHT else None


def _tilt(ground: Plane) -> Quaternion:
    """Return the rotation from the vertical to the normal of the ground."""
    x, y, z = ground.normal_W
    lean = hypot(x, y)
    return IDENTITY if lean == 0.0 else about((-y / lean, x / lean, 0.0), acos(max(-1.0, min(1.0, z))))


def _pose_turned(pose: Pose, turn: Quaternion) -> Pose:
    return Pose(rotate(turn, pose.position_W), multiply(turn, pose.orientation))


def _turned(plane: Plane, turn: Quaternion) -> Plane:
    if turn in (IDENTITY, inverse(IDENTITY)):
        return plane
    return Plane(plane.id, rotate(turn, plane.point_W), rotate(turn, plane.normal_W), plane.friction)


# Counter-based random numbers: they depend on their purpose only, not on earlier draws.
#
# Philox maps a key and a counter to bits. The key is a digest of seed, scenario and subject (a brick or a variable).
# The counter has the number of the sample and of the attempt. So a sample is the same on every machine, in any order of
# evaluation, and whichever other numbers are drawn.


EACH: Final = 4  # random numbers per count
BITS: Final = 53  # of the mantissa of a double


@dataclass(frozen=True, slots=True)
class Draws:
    """A batch of consecutive samples of a scenario."""

    seed: int
    scenario: str
    first: int  # the number of the first sample
    count: int

    def uniform(self, subject: str, attempt: int = 0) -> Array:
        """Return uniform random numbers in the open interval (0, 1), of shape (EACH, count)."""
        digest = sha256(f"{self.seed}\n{self.scenario}\n{subject}".encode()).digest()
        key = np.frombuffer(digest[:16], dtype="<u8").astype(np.uint64)
        counter = np.array([self.first, attempt, 0, 0], dtype=np.uint64)
        drawn = np.random.Philox(key=key, counter=counter).random_raw(EACH * self.count)
        numbers = ((drawn >> np.uint64(64 - BITS)).astype(np.float64) + 0.5) * 2.0**-BITS
        return numbers.reshape(self.count, EACH).T


# Samples with uncertain variables: each has its own values and is compiled separately.


WITHIN = "limit the distribution, such as {normal: 0.5 ± 0.2, least: 0.1}, or use a positive one, such as lognormal"
ELSEWHERE = "limit the distribution to values with which the scenario can be built, such as 5 mm ± 1 mm"


class InvalidSampleError(Exception):
    """A sample has values that make the scenario invalid, such as a friction below zero."""

    def __init__(self, mistake: Diagnostic) -> None:
        super().__init__(mistake)  # as the only argument, so that the exception can be pickled
        self.mistake = mistake

    def __str__(self) -> str:
        return self.mistake.message


@dataclass(frozen=True, slots=True)
class Setting:
    """Changes of the scenario that are the same in all samples."""

    fixed: Mapping[str, Plain] = field(default_factory=dict)  # values of variables and of `friction`
    errors: float = 1.0  # factor on all placement errors


AS_WRITTEN = Setting()


@dataclass(slots=True)
class Picks:
    """Draws the values of one sample, as an author would write them."""

    draws: Draws  # of one sample
    values: dict[str, Plain] = field(default_factory=dict)  # drawn so far, by variable

    def __call__(self, name: str, each: Distribution) -> Plain:
        """Return the value of a variable; it does not depend on other variables."""
        number = float(self.draws.uniform(f"= {name}")[0, 0])  # no brick can have this name
        self.values[name] = each.at(number, ndtri)
        return self.values[name]


def picks(draws: Draws) -> Iterator[Picks]:
    """Yield the values of each sample."""
    for number in range(draws.first, draws.first + draws.count):
        yield Picks(replace(draws, first=number, count=1))


def timelines(variant: Variant, draws: Draws, setting: Setting = AS_WRITTEN) -> Iterator[Timeline]:
    """Yield the timeline of each sample. Raises InvalidSampleError if a sample is invalid."""
    for pick in picks(draws):
        timeline = timeline_at(variant, setting, pick)
        if isinstance(timeline, Diagnostic):
            raise InvalidSampleError(_of_sample(pick, timeline, setting) if pick.values else timeline)
        yield timeline


def timeline_at(variant: Variant, setting: Setting, pick: Pick = middle) -> Timeline | Diagnostic:
    """Return the timeline with changed values, or the first diagnostic if it is invalid."""
    sample, mistaken = resampled(variant, pick, setting.fixed)
    scenario, mistakes = validate(sample.source, sample)
    timeline = None
    if scenario is not None and not mistaken:
        timeline, mistakes = compile_timeline(scenario, sample.source)
    if timeline is not None:
        return _with_errors(timeline, setting.errors)
    diagnostics = [*diagnostics_of([(sample.source, mistaken)]), *mistakes]
    first = (
        diagnostics[0]
        if diagnostics
        else Diagnostic("SD104", sample.source.span_of(()), "the scenario cannot be built")
    )
    if not setting.fixed:
        return first
    fixed = ", ".join(f"{name} = {value}" for name, value in setting.fixed.items())
    return replace(first, message=f"with {fixed}: {first.message}")


def _of_sample(pick: Picks, mistake: Diagnostic, setting: Setting) -> Diagnostic:
    values = ", ".join(f"{name} = {value}" for name, value in pick.values.items())
    hint = WITHIN if mistake.code == "SD104" else ELSEWHERE
    hint = mistake.hint if setting.fixed else hint  # the fixed value may be out of range rather than the sample
    return replace(mistake, message=f"sample {pick.draws.first} has {values}: {mistake.message}", hint=hint)


def _with_errors(timeline: Timeline, times: float) -> Timeline:
    if times == 1.0:
        return timeline
    return replace(timeline, jitter={name: _multiplied(each, times) for name, each in timeline.jitter.items()})


def _multiplied(jitter: Jitter, times: float) -> Jitter:
    position, yaw = (
        None if each is None else ErrorSpread(each.kind, each.width * times) for each in (jitter.position, jitter.yaw)
    )
    return Jitter(position, yaw)
