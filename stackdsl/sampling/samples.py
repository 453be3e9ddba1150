"""Draws samples of a scenario: placement errors, uncertain variables, counter-based random numbers."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from math import acos, hypot, inf
from typing import Final

import numpy as np
from scipy.special import ndtri

from stability.analysis.sampled_columns import Mask
from stability.contact_law import GivenFriction
from stability.contacts.bodies import BoxSolid, solid
from stability.geometry.box import Box
from stability.geometry.box_distance import gap_bridged, reach_between
from stability.geometry.placed_shape import corners_W
from stability.geometry.rows import Array
from stability.geometry.vectors import about, inverse, multiply, rotate
from stability.model import GROUND, IDENTITY, BodyId, Plane, Pose, Quaternion
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

# What is built, brick by brick in the order of the hands: what each belongs on, and what it may meet.


@dataclass(frozen=True, slots=True)
class DesignedBrick:
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

    def reach(self, other: "DesignedBrick") -> float:
        """From which the two still touch [m]."""
        return reach_between(self.thickness, other.thickness)


@dataclass(frozen=True, slots=True)
class Unit:
    """Bricks that hands set down as one: alone, or two that lean on each other."""

    parts: tuple[DesignedBrick, ...]
    supports: tuple[int, ...]  # the bricks that it belongs on
    grounded: bool  # whether it belongs on the ground as well, or stands free
    centre: tuple[float, float]  # the mean of its bricks, in plan [m]

    @property
    def jitter(self) -> Jitter | None:
        """The errors that it is set down with."""
        return self.parts[0].jitter


@dataclass(frozen=True, slots=True)
class BuildStage:
    """What comes at one time, and is judged together."""

    units: tuple[Unit, ...]
    level: int  # under construction


@dataclass(frozen=True)
class BuildPlan:
    """A structure to be built by hands, unit by unit."""

    moments: tuple[BuildStage, ...]
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
    def parts(self) -> tuple[DesignedBrick, ...]:
        """All bricks in the order of the hands."""
        return tuple(part for moment in self.moments for unit in moment.units for part in unit.parts)

    @property
    def is_flat(self) -> bool:
        """Whether all are boxes that lie flat on what is level."""
        return self.tilt == IDENTITY and all(part.flat is not None for part in self.parts)


def build_plan_of(timeline: Timeline) -> BuildPlan:
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
        moments.append(BuildStage(tuple(units), level))
    return BuildPlan(tuple(moments), planes, world.planes, tilt, world.friction, world.gravity, world.tolerances)


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


def _part(number: int, placed: Placed, structure: Structure, jitter: Jitter | None) -> DesignedBrick:
    own = solid(placed)
    flat = own.plan if isinstance(own, BoxSolid) and isinstance(placed.brick.shape, Box) else None
    name, (x, y, _) = placed.brick.id, placed.pose.position_W
    corners = corners_W(placed.brick.shape, placed.pose)
    radius = max(hypot(cx - x, cy - y) for cx, cy, _ in corners)
    carried = tuple(c for c in structure.touching[name].values() if c.upper == name and carries_upright(c))
    low, high = min(z for _, _, z in corners), max(z for _, _, z in corners)
    return DesignedBrick(number, placed, flat, low, high, radius, placed.brick.shape.least_thickness, carried, jitter)


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


# Random numbers by counting: what is drawn for a sample depends on what it is for, and on nothing drawn before.
#
# Philox turns a key and a counter into bits. The key is a digest of seed, scenario and subject (a brick, or a
# variable), the counter is the number of the sample, and of the attempt where the first does not do. So a sample is the
# same on every machine, in every order, and whatever else is drawn.


EACH: Final = 4  # numbers that one count gives
BITS: Final = 53  # of a double


@dataclass(frozen=True, slots=True)
class Draws:
    """Samples of a scenario that follow each other."""

    seed: int
    scenario: str
    first: int  # the number of the first sample
    count: int

    def uniform(self, subject: str, attempt: int = 0) -> Array:
        """(EACH, count) numbers between 0 and 1, neither of them included."""
        digest = sha256(f"{self.seed}\n{self.scenario}\n{subject}".encode()).digest()
        key = np.frombuffer(digest[:16], dtype="<u8").astype(np.uint64)
        counter = np.array([self.first, attempt, 0, 0], dtype=np.uint64)
        drawn = np.random.Philox(key=key, counter=counter).random_raw(EACH * self.count)
        numbers = ((drawn >> np.uint64(64 - BITS)).astype(np.float64) + 0.5) * 2.0**-BITS
        return numbers.reshape(self.count, EACH).T


# What is uncertain but the hands: samples of which each is compiled by itself, with values of its own.


WITHIN = "draw it within its limits: {normal: 0.5 ± 0.2, least: 0.1}, or one that has them, such as a lognormal one"
ELSEWHERE = "draw it within limits in which it can be built, such as 5 mm ± 1 mm"


class SampleMistakeError(Exception):
    """A sample has values that no scenario may have, such as a friction below zero."""

    def __init__(self, mistake: Diagnostic) -> None:
        super().__init__(mistake)  # so that it can be sent from process to process
        self.mistake = mistake

    def __str__(self) -> str:
        return self.mistake.message


@dataclass(frozen=True, slots=True)
class Setting:
    """What is otherwise than written, in all samples alike."""

    fixed: Mapping[str, Plain] = field(default_factory=dict)  # variables, and `friction`, with the values they have
    errors: float = 1.0  # by which the errors of hands are multiplied


AS_WRITTEN = Setting()


@dataclass(slots=True)
class Picks:
    """The values of one sample, as an author would write them."""

    draws: Draws  # of one sample
    values: dict[str, Plain] = field(default_factory=dict)  # by variable, as far as they were asked for

    def __call__(self, name: str, each: Distribution) -> Plain:
        """The value of a variable, whatever others there are."""
        number = float(self.draws.uniform(f"= {name}")[0, 0])  # no brick is called so
        self.values[name] = each.at(number, ndtri)
        return self.values[name]


def picks(draws: Draws) -> Iterator[Picks]:
    """For each sample."""
    for number in range(draws.first, draws.first + draws.count):
        yield Picks(replace(draws, first=number, count=1))


def timelines(variant: Variant, draws: Draws, setting: Setting = AS_WRITTEN) -> Iterator[Timeline]:
    """The timeline of each sample. Raises SampleMistakeError."""
    for pick in picks(draws):
        made = timeline_at(variant, setting, pick)
        if isinstance(made, Diagnostic):
            raise SampleMistakeError(_of_sample(pick, made, setting) if pick.values else made)
        yield made


def timeline_at(variant: Variant, setting: Setting, pick: Pick = middle) -> Timeline | Diagnostic:
    """The timeline with some values otherwise than written, or why there is none."""
    sample, mistaken = resampled(variant, pick, setting.fixed)
    scenario, mistakes = validate(sample.source, sample)
    timeline = None
    if scenario is not None and not mistaken:
        timeline, mistakes = compile_timeline(scenario, sample.source)
    if timeline is not None:
        return _with_errors(timeline, setting.errors)
    told = [*diagnostics_of([(sample.source, mistaken)]), *mistakes]
    first = told[0] if told else Diagnostic("SD104", sample.source.span_of(()), "it cannot be built")
    if not setting.fixed:
        return first
    fixed = ", ".join(f"{name} = {value}" for name, value in setting.fixed.items())
    return replace(first, message=f"with {fixed}: {first.message}")


def _of_sample(pick: Picks, mistake: Diagnostic, setting: Setting) -> Diagnostic:
    which = ", ".join(f"{name} = {value}" for name, value in pick.values.items())
    hint = WITHIN if mistake.code == "SD104" else ELSEWHERE
    hint = mistake.hint if setting.fixed else hint  # which may be what is out of range
    return replace(mistake, message=f"sample {pick.draws.first} has {which}: {mistake.message}", hint=hint)


def _with_errors(timeline: Timeline, times: float) -> Timeline:
    if times == 1.0:
        return timeline
    return replace(timeline, jitter={name: _multiplied(each, times) for name, each in timeline.jitter.items()})


def _multiplied(jitter: Jitter, times: float) -> Jitter:
    position, yaw = (
        None if each is None else ErrorSpread(each.kind, each.width * times) for each in (jitter.position, jitter.yaw)
    )
    return Jitter(position, yaw)
