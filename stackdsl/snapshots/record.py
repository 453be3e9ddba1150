"""What a golden file locks of a run, as values, and how finely each kind of number is held.

Facts that a person can read, and that a small disturbance does not change: a collapse is chaotic once it is under way,
and a bare engine creeps. What is not clear-cut is written as `unclear`, which compares equal to anything, or left out.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from stability.model import BodyId

FORMAT = 1  # of the file; raise it whenever an older file can no longer be compared
COMPACT_FORMAT = 2  # of one that tells of very many bricks by level; both are read
UNCLEAR = "unclear"  # too close to call; equal to anything


class MalformedSnapshotError(ValueError):
    """A golden file holds JSON, yet no snapshot; the message says where."""


Number: TypeAlias = float | str  # text where a number is unclear or not finite: JSON has no infinity


@dataclass(frozen=True, slots=True)
class Quantity:
    """A kind of number: how it is written, and how far it may move until it counts as different."""

    unit: str
    digits: int  # decimals written; of a result ten times finer than the tolerance, so rounding never decides
    tolerance: float  # in `unit`


POSITION = Quantity("mm", 2, 0.5)  # half the moulding tolerance of a brick
HEIGHT = Quantity("mm", 2, 0.5)  # as POSITION: it is the top of one brick
MARGIN = Quantity("mm", 2, 0.2)  # finer than POSITION: contact corners, which it is made of, agree within 0.1 mm
SHARE = Quantity("", 3, 0.02)  # what 0.5 mm does on a lever of 24 mm, a plank's width
COLLAPSE_TIME = Quantity("s", 3, 0.05)  # solvers differ by up to 0.02 s in when a tower has visibly begun to fall
PLACING_TIME = Quantity("s", 3, 0.005)  # one step of the coarsest engine, 1/240 s
# What the author wrote is compared as exactly as it is locked: to the last digit, which rounding may turn.
PLACE = Quantity("mm", 2, 0.01)
TURN = Quantity("deg", 3, 0.001)
SIZE = Quantity("mm", 4, 0.0001)
VOLUME = Quantity("mm3", 3, 0.001)
MASS = Quantity("g", 5, 0.00001)
GRAVITY = Quantity("m/s2", 6, 0.000001)
FRICTION = Quantity("", 6, 0.000001)
NORMAL = Quantity("", 6, 0.000001)


@dataclass(frozen=True, slots=True)
class Identity:
    """Which run it is."""

    scenario: str
    variant: str  # such as `step=10mm,thesis`
    system: str


@dataclass(frozen=True, slots=True)
class FirstCollapse:
    """The collapse; what is None is not locked."""

    level: int
    time_s: Number | None
    gave_way: BodyId | None


@dataclass(frozen=True, slots=True)
class PlacedBrick:
    """Where a brick was set down, and who carried it once it had been judged."""

    at_mm: tuple[Number, ...]  # centre of mass in W
    turn_deg: tuple[Number, ...]  # from body axes to W: axis times angle
    size_mm: tuple[Number, ...]  # of the box around it, along its own axes
    mass_g: Number
    rests_on: Mapping[BodyId, Number] | None  # shares; None where no model tells
    centre_of_mass_mm: tuple[Number, ...] | None = None  # from the middle of the box around it; None if it is a box
    volume_mm3: Number | None = None  # None of a box


@dataclass(frozen=True, slots=True)
class Placing:
    """Bricks set down at one time."""

    time_s: Number
    margin_mm: Number | None  # least tipping margin of the stack afterwards; None where no model tells
    placed: Mapping[BodyId, PlacedBrick]


@dataclass(frozen=True, slots=True)
class Removing:
    """Bricks pulled out at one time."""

    time_s: Number
    removed: tuple[BodyId, ...]


@dataclass(frozen=True, slots=True)
class Pushing:
    """Bricks pushed at one time."""

    time_s: Number
    pushed: tuple[BodyId, ...]


@dataclass(frozen=True, slots=True)
class FinalBrick:
    """How a brick ended; what is None is not locked."""

    level: int
    state: str  # a BrickState, or UNCLEAR
    at_mm: tuple[Number, ...] | None
    rests_on: Mapping[BodyId, Number] | None


@dataclass(frozen=True, slots=True)
class FixedPlane:
    """The ground or a wall."""

    at_mm: tuple[Number, ...]
    normal: tuple[Number, ...]
    friction: Number


@dataclass(frozen=True, slots=True)
class Scene:
    """What does not move, so that a snapshot is never the same as that of another scene."""

    gravity: Number  # [m/s2]
    friction: Number
    planes: Mapping[BodyId, FixedPlane]
    rubbing: Mapping[str, Number | str] | None = None  # what rubs otherwise; None where one coefficient is all


@dataclass(frozen=True, slots=True)
class Samples:
    """What became of many samples: exact, for the seed says which they are."""

    seed: int
    drawn: int
    stood: int
    fell: Mapping[str, int]  # by level
    undecided: int
    unfit: int


@dataclass(frozen=True, slots=True)
class Snapshot:
    """All that is locked of one run; what is None is not locked."""

    identity: Identity
    stamp: Mapping[str, str]  # versions of what made it
    world: Scene
    verdict: str
    statics: str | None  # what was proven when bricks were last set down; None where no system proves
    collapse: FirstCollapse | None
    height_mm: Number | None  # of what stands
    levels_standing: Number | None  # counted from the first, as long as every brick of a level stands
    events: tuple[Placing | Removing | Pushing, ...]
    bricks: Mapping[BodyId, FinalBrick]  # by level, then name
    kept_by: str | None = None  # as `stackdsl.snapshots.keepers` says; never compared
    samples: Samples | None = None  # None of one run

    @property
    def placings(self) -> tuple[Placing, ...]:
        """The events in which bricks were set down."""
        return tuple(event for event in self.events if isinstance(event, Placing))
