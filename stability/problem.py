"""The data of statics: bricks in place, contacts, forces, motions, verdicts. SI units, frame W, z up."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import inf
from typing import Protocol, TypeAlias

from stability.contact_law import ContactLaw
from stability.geometry.box_distance import TOUCHING
from stability.model import BodyId, Brick, Pose, Vec3

# The facts of statics: bricks in their places, contacts, forces, motions, verdicts. SI units, frame W, z up.
#
# A body that is not among the bricks of a problem is fixed: the ground, a wall, or a brick that is taken as fixed.


ZERO: Vec3 = (0.0, 0.0, 0.0)
UP: Vec3 = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Placed:
    """A brick in its place."""

    brick: Brick
    pose: Pose


def by_place(placed: Placed) -> tuple[float, float, float]:
    """Sorts bricks upwards, by their places alone: neither names nor the order in which they are given decide."""
    x, y, z = placed.pose.position_W
    return z, x, y


@dataclass(frozen=True, slots=True)
class Wrench:
    """A force on a brick [N], and its torque about the brick's centre of mass [N m]."""

    force_W: Vec3
    torque_W: Vec3 = ZERO


@dataclass(frozen=True, slots=True)
class Contact:
    """Where two bodies press on each other: forces act at points, as its law allows about normals.

    A force anywhere on a flat patch is a sum of forces at its corners, so corners are enough. More than one normal:
    edges or corners that meet admit every normal between these extreme ones, and so every sum of forces in their cones.
    """

    lower: BodyId
    upper: BodyId
    points_W: tuple[Vec3, ...]  # one point, the two ends of a line, or the corners of a convex patch in order [m]
    normals_W: tuple[Vec3, ...]  # unit, from `lower` towards `upper`; their sum does not point down
    law: ContactLaw  # which forces it can bear at each point
    # By point, how far the bodies are apart there [m], 0 where they are not; empty where they are so nowhere.
    gaps: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Problem:
    """The question whether contact forces can balance the loads on some bricks."""

    bricks: Mapping[BodyId, Placed]  # free to move; whatever else a contact names is fixed
    contacts: Sequence[Contact]
    loads: Mapping[BodyId, Wrench]  # on each brick, its weight included


ConeForces: TypeAlias = tuple[tuple[Vec3, ...], ...]  # by point, then by normal


@dataclass(frozen=True, slots=True)
class Forces:
    """Forces that may balance a problem: for each of its contacts, those of `lower` on `upper`, in W [N]."""

    of_contacts: Sequence[ConeForces]


@dataclass(frozen=True, slots=True)
class Motion:
    """Velocities that may lower a problem's potential energy; bricks that are not named stay where they are."""

    velocity: Mapping[BodyId, tuple[Vec3, Vec3]]  # of the centre of mass [m/s], and angular [rad/s]; of any size


class Stability(StrEnum):
    """What is proven of an assembly."""

    STABLE = "stable"  # there are forces that balance it, and they do not rest on self-stress
    UNSTABLE = "unstable"  # there is a motion that no admissible forces can stop
    UNDECIDED = "undecided"  # neither was proven; the verdict says why


class Stage(StrEnum):
    """The stage of the cascade that gave an answer, cheapest first."""

    LOAD_CORE = "load core"  # what it weighs is carried to the ground by what stands, whatever else that carries
    PROPAGATION = "weight propagation"  # its weight was passed down, brick by brick
    TIPPING = "tipping"  # it tips as one body, with all it carries, about an edge of its support
    VERTICAL = "vertical forces"  # a linear program found vertical forces
    CONES = "friction cones"  # the exact problem, a conic program


class GapQuestion(Protocol):
    """How wide gaps must count as contact for something to be proven stable."""

    def within(self) -> float:
        """So wide [m]; 0 where it is stable with none."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What was found of an assembly, by which stage, and with which proof."""

    stability: Stability
    stage: Stage | None = None  # None where there was nothing to judge
    reason: str = ""  # in words: what moves and how, or why nothing could be proven
    moving: tuple[BodyId, ...] = ()  # UNSTABLE: a smallest set of bricks that moves; UNDECIDED: those in doubt
    motion: Motion | None = None  # the proof of UNSTABLE
    seconds: float = field(default=0.0, compare=False)  # what the answer cost [s of wall time]
    # STABLE: asked where bricks touch across gaps. An answer costs as much as some verdicts, so it comes on demand.
    gaps: tuple[GapQuestion, ...] = field(default=(), compare=False, repr=False)

    @property
    def touching_within(self) -> float:
        """STABLE counts on gaps up to this width as contact [m], as `Tolerances.within` says; 0 if it needs none."""
        return max((question.within() for question in self.gaps), default=0.0)


@dataclass(frozen=True, slots=True)
class Tolerances:
    """How exact statics is. Lengths are shares of the smallest side of the bricks concerned: size does not matter."""

    gap: float = TOUCHING  # bodies this far apart, or this deep in each other, are in contact
    within: float = inf  # [m] no wider gap is contact, whatever `gap` says; at 0, no gap at all
    # Of the forces on a brick, relative to what it carries; of their torques, relative to that and its half diagonal.
    # At 1e-9 a column of 300 planks passes a millionth beyond its limit: residuals add up over its height.
    residual: float = 1e-11
    # Of relative speeds at a contact, relative to the speed there. A motion that violates a contact by more is none.
    violation: float = 1e-9
    # Of the power of gravity, less what violations may cost, relative to the sum of weight times speed.
    gain: float = 1e-10


# Rounding error of a residual by coordinates far from the origin.


LOST_DIGITS = 1e-15  # share of a coordinate, a few times the error of one rounding


def rounded(problem: Problem, tolerances: Tolerances) -> Tolerances:
    """Tolerances, with what is lost where the bricks of a problem are."""
    furthest = max((abs(part) for p in problem.bricks.values() for part in p.pose.position_W), default=0.0)
    smallest = min((p.brick.shape.length for p in problem.bricks.values()), default=1.0)
    return replace(tolerances, residual=tolerances.residual + LOST_DIGITS * furthest / smallest)
