"""Data types of statics: placed bricks, contacts, forces, motions, verdicts. SI units, frame W, z up.

A body that is not among the bricks of a problem is fixed: the ground, a wall, or a brick that counts as fixed.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import inf
from typing import Protocol, TypeAlias

from stability.contact_law import ContactLaw, OtherLawError
from stability.geometry.box_distance import TOUCHING
from stability.geometry.round_patch import RoundPatch
from stability.geometry.vectors import add_scaled, short_repr, subtract
from stability.model import BodyId, Brick, Pose, Vec3
from stability.name_order import names_text
from stability.notebook import Display, Displayed, display_of

ZERO: Vec3 = (0.0, 0.0, 0.0)
UP: Vec3 = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Placed:
    """Brick at a pose."""

    brick: Brick
    pose: Pose


def by_place(placed: Placed) -> tuple[float, float, float]:
    """Return a sort key by position, upwards, so that the order does not depend on names."""
    x, y, z = placed.pose.position_W
    return z, x, y


@dataclass(frozen=True, slots=True)
class Wrench:
    """A force on a brick [N], and its torque about the brick's centre of mass [N m]."""

    force_W: Vec3
    torque_W: Vec3 = ZERO

    def minus(self, other: "Wrench | None") -> "Wrench":
        """Return the difference to another wrench, or to none."""
        if other is None:
            return self
        return Wrench(subtract(self.force_W, other.force_W), subtract(self.torque_W, other.torque_W))

    def plus(self, other: "Wrench", times: float = 1.0) -> "Wrench":
        """Return the sum with a multiple of another wrench."""
        return Wrench(add_scaled(self.force_W, times, other.force_W), add_scaled(self.torque_W, times, other.torque_W))


@dataclass(frozen=True, slots=True)
class RollingWay:
    """Direction in which the upper body of a contact can roll on the lower one, and a point of each body.

    The points are the centres of curvature; of a body that is not curved in this direction it is the contact itself.
    The contact moves if one point moves past the other along the direction.
    """

    direction_W: Vec3  # unit
    lower_W: Vec3  # [m]
    upper_W: Vec3


@dataclass(frozen=True, slots=True)
class Contact:
    """Contact of two bodies: forces act at points, within the limits of its law about normals.

    A force at any point of a flat patch is a sum of forces at its corners, so these suffice. Edges or corners in
    contact admit every normal between several extreme ones, and so every sum of forces about these.
    """

    lower: BodyId
    upper: BodyId
    points_W: tuple[Vec3, ...]  # a point, the two ends of a line, or the ordered corners of a convex patch [m]
    normals_W: tuple[Vec3, ...]  # unit, from `lower` towards `upper`; their sum points down only from a plane above
    law: ContactLaw  # admissible forces at each point
    # Gap at each point [m]; empty if all are 0.
    gaps: tuple[float, ...] = ()
    # Tension, cohesion and shear of the brittle joint to which it belongs [Pa].
    brittle: tuple[float, float, float] | None = None
    # A patch with a round border; the points are then the corners of its inner polygon.
    patch: RoundPatch | None = None
    rolling: tuple[RollingWay, ...] = ()

    @property
    def around_W(self) -> tuple[Vec3, ...]:
        """Points whose convex hull holds the whole contact [m]: those that no motion may resist at."""
        return self.points_W if self.patch is None else self.patch.placed(self.patch.outer)

    def refined(self, patch: RoundPatch) -> "Contact":
        """Return the contact with another inner polygon of the same patch."""
        gaps = tuple(max(0.0, patch.gap_at(point)) for point in patch.inner) if self.gaps else ()
        return replace(self, points_W=patch.placed(patch.inner), gaps=gaps, patch=patch)


@dataclass(frozen=True, slots=True)
class UnknownTension:
    """Tension of a cable that pulls bricks, unknown within bounds; `Problem.loads` has the pulls at the lower one."""

    name: str
    pulls: Mapping[BodyId, Wrench]  # on bricks, at a tension of 1 N
    least: float  # [N]
    most: float

    @property
    def more(self) -> float:
        """Return by how much it may exceed the least tension [N]."""
        return self.most - self.least


@dataclass(frozen=True, slots=True)
class Problem:
    """Equilibrium problem: bricks with contacts and loads."""

    bricks: Mapping[BodyId, Placed]  # free to move; other bodies of contacts are fixed
    contacts: Sequence[Contact]
    loads: Mapping[BodyId, Wrench]  # on each brick, including its weight
    # The parts of these that are no weight of a brick.
    applied: Mapping[BodyId, Wrench] = field(default_factory=dict)
    # The parts that are pulls of ties at their least tension; neither weights nor `applied`.
    pulled: Mapping[BodyId, Wrench] = field(default_factory=dict)
    ties: Sequence[UnknownTension] = ()

    @property
    def unloaded(self) -> "Problem":
        """Return the problem under the weights of the bricks alone."""
        return replace(self.without(self.applied), applied={})

    @property
    def weights(self) -> Mapping[BodyId, Wrench]:
        """Return the weights of the bricks."""
        return self.unloaded.without(self.pulled).loads

    def without(self, loads: Mapping[BodyId, Wrench]) -> "Problem":
        """Return the problem with some loads taken away."""
        return replace(self, loads={name: load.minus(loads.get(name)) for name, load in self.loads.items()})

    def drawn(self, more: Sequence[float]) -> "Problem":
        """Return the problem with ties drawn tighter than the least tension [N], and known."""
        loads = dict(self.loads)
        for tie, tension in zip(self.ties, more, strict=True):
            for name, pull in tie.pulls.items():
                loads[name] = loads[name].plus(pull, tension)
        return replace(self, loads=loads, ties=())

    @property
    def is_tied(self) -> bool:
        """Return whether ties pull some bricks."""
        return bool(self.pulled or self.ties)

    @property
    def has_joints(self) -> bool:
        """Return whether some forces are bounded, so that proofs of equilibrium cannot all be added."""
        return bool(self.ties) or not all(contact.law.is_cone for contact in self.contacts)

    @property
    def is_round(self) -> bool:
        """Return whether some contacts have round borders, or are on curved surfaces."""
        return any(contact.patch is not None or contact.rolling for contact in self.contacts)

    def part(self, bricks: Collection[BodyId]) -> "Problem":
        """Return the problem of some bricks with the others held fixed."""
        return replace(
            self,
            bricks={name: self.bricks[name] for name in sorted(bricks)},
            contacts=[c for c in self.contacts if c.lower in bricks or c.upper in bricks],
            ties=[
                replace(tie, pulls=own)
                for tie in self.ties
                if (own := {name: pull for name, pull in tie.pulls.items() if name in bricks})
            ],
        )

    @property
    def is_brittle(self) -> bool:
        """Return whether some joints shed their force when they yield."""
        return any(contact.brittle is not None for contact in self.contacts)

    def require_dry(self, what: str) -> None:
        """Raise OtherLawError if there are joints, for an analysis that supports dry contacts only."""
        if self.has_joints:
            kind = "ties of unknown tension" if self.ties else "joints"
            raise OtherLawError(f"{what} is not supported for bricks with {kind}; only verdicts and load factors are")


def admit_problem(problem: object) -> None:
    """Raise TypeError for anything but a problem of statics."""
    if not isinstance(problem, Problem):
        of_scenario = type(problem).__module__.startswith("stackdsl.")
        remedy = "; for a scenario write `stackdsl.margins(scenario)`" if of_scenario else ""
        raise TypeError(f"expected a Problem, as returned by `assembly.problem()`, not {short_repr(problem)}{remedy}")


ConeForces: TypeAlias = tuple[tuple[Vec3, ...], ...]  # forces by point, then by normal


@dataclass(frozen=True, slots=True)
class Forces:
    """Candidate forces for the balance of a problem: for each contact those of `lower` on `upper`, in W [N]."""

    of_contacts: Sequence[ConeForces]
    more_tension: Sequence[float] = ()  # of each tie of unknown tension, above its least one [N]


@dataclass(frozen=True, slots=True)
class Motion:
    """Candidate motion that lowers a problem's potential energy; other bricks are at rest."""

    velocity: Mapping[BodyId, tuple[Vec3, Vec3]]  # of the centre of mass [m/s], and angular [rad/s]; of any scale


@dataclass(frozen=True, slots=True)
class PlacementLimit:
    """A contact beyond whose border the load of the upper body gets first, and the directions in which it does."""

    lower: BodyId
    upper: BodyId
    bearings: tuple[float, ...]  # from +x towards +y, from 0 to 2 pi, rising [rad]


class Stability(StrEnum):
    """Proven stability of an assembly."""

    STABLE = "stable"  # admissible forces balance it, without self-stress
    UNSTABLE = "unstable"  # no admissible forces stop a motion
    UNDECIDED = "undecided"  # neither was proven; the verdict gives the reason


class Stage(StrEnum):
    """Stage of the cascade that gave a verdict, cheapest first."""

    LOAD_CORE = "load core"  # the load cores of standing bricks carry its weight
    PROPAGATION = "weight propagation"  # its weight was passed down, brick by brick
    TIPPING = "tipping"  # it tips as one body, with all that it carries, about an edge of its support
    VERTICAL = "vertical forces"  # a linear program found vertical forces
    CONES = "friction cones"  # the exact problem, a conic program


class GapQuestion(Protocol):
    """Query of the largest gap that a proof of stability needs as contact."""

    def within(self) -> float:
        """Return the largest gap [m]; 0 if the proof needs none."""


@dataclass(frozen=True, slots=True)
class Crushing:
    """The brick that crushes first, and the share of its strength that all possible forces need."""

    brick: BodyId
    share: float  # above 1

    @property
    def need(self) -> str:
        """Return the share in words."""
        percent = f"{100.0 * self.share:.4g}"
        percent = f"{100.0 * self.share:.8g}" if percent == "100" else percent
        return f"it needs {percent} % of its strength"

    @property
    def text(self) -> str:
        """Return both in words."""
        return f"{self.brick} crushes: {self.need}"


@dataclass(frozen=True, slots=True)
class Verdict(Displayed):
    """Verdict on an assembly, with its stage and its proof."""

    stability: Stability
    stage: Stage | None = None  # None without bricks
    reason: str = ""  # description of the motion, or of the reason for no proof
    moving: tuple[BodyId, ...] = ()  # UNSTABLE: a smallest set of moving bricks; UNDECIDED: the undecided ones
    motion: Motion | None = None  # proof of UNSTABLE
    seconds: float = field(default=0.0, compare=False)  # wall time of the proof [s]
    # STABLE with contacts across gaps: queries that cost as much as some verdicts, so they run on demand.
    gaps: tuple[GapQuestion, ...] = field(default=(), compare=False, repr=False)
    crushing: Crushing | None = None  # cause of UNSTABLE if forces balance all bricks, but none that these bear

    @property
    def touching_within(self) -> float:
        """Largest gap that STABLE needs as contact [m], in the sense of `Tolerances.within`; 0 if it needs none."""
        return max((question.within() for question in self.gaps), default=0.0)


WORDS = {Stability.STABLE: ("\u2713 stable", True), Stability.UNSTABLE: ("\u2717 unstable", False)}


@display_of.register
def _(verdict: Verdict) -> Display:
    word, good = WORDS.get(verdict.stability, (f"\u2013 {verdict.stability}", None))
    told = {"why": verdict.reason, "moves": names_text(verdict.moving), "proof": verdict.stage or ""}
    return Display("statics", [(label, text) for label, text in told.items() if text], word, good)


@dataclass(frozen=True, slots=True)
class Tolerances:
    """Tolerances of statics. Lengths are shares of the smallest side of the bricks, independent of the scale."""

    gap: float = TOUCHING  # largest gap or overlap of a contact
    within: float = inf  # [m] largest gap of a contact, in addition to `gap`; 0 allows no gap
    # Residual of the forces on a brick, relative to its load; of the torques, relative to load times half diagonal. At
    # 1e-9 a column of 300 planks passes a millionth beyond its limit, as residuals add up over its height.
    residual: float = 1e-11
    # Largest violation of a contact by a motion, relative to the speed at the contact.
    violation: float = 1e-9
    # Least power of gravity, minus the cost of violations, relative to the sum of weight times speed.
    gain: float = 1e-10


LOST_DIGITS = 1e-15  # share of a coordinate: a few rounding errors


def rounded(problem: Problem, tolerances: Tolerances) -> Tolerances:
    """Return tolerances that include the rounding of coordinates far from the origin."""
    furthest = max((abs(part) for p in problem.bricks.values() for part in p.pose.position_W), default=0.0)
    smallest = min((p.brick.shape.length for p in problem.bricks.values()), default=1.0)
    return replace(tolerances, residual=tolerances.residual + LOST_DIGITS * furthest / smallest)
