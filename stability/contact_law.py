"""The law of a contact: which forces it can bear at a point, and which coefficient of friction two bodies have.

`Contact.law` alone knows the set of forces. Proofs and solvers ask it, so that another law is one more class here.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import inf, sqrt
from typing import Any, ClassVar, Final, Self, TypeAlias

from stability.geometry.vectors import admit_in_range, admit_number, told
from stability.model import BodyId, Plane

# The forces that a contact can bear at one of its points: a convex set, round about the normal there.
#
# As the set is round, a force counts by its part along the normal and the size of the rest; a slip by how fast it opens
# the contact and how fast it slides along it. A force is that of the lower body on the upper one, a slip the velocity
# of the upper body against the lower one.


Numbers: TypeAlias = Any  # a number, or an array with one entry a point: arithmetic with both is written alike


@dataclass(frozen=True, slots=True)
class ContactLaw(ABC):
    """The forces that a contact can bear at a point.

    Its fields are numbers that are not negative. They may be arrays with one entry a point, and so may be all that its
    methods take and give: then it is the law of many points at once.
    """

    # Whether the contact can bear the sum of any forces that it can bear; else proofs that use it must not be added.
    is_cone: ClassVar[bool]

    friction: Numbers  # Coulomb coefficient: by how much the greatest friction grows with the normal force

    @property
    @abstractmethod
    def least_normal(self) -> Numbers:
        """The least normal force [N]; negative where the contact can pull."""

    @abstractmethod
    def greatest_friction(self, normal: Numbers) -> Numbers:
        """The greatest tangential force at a normal force [N]."""

    @abstractmethod
    def lift(self, sliding: Numbers) -> Numbers:
        """How fast a slip must open the contact for what forces can take from it to be bounded [m/s]."""

    @abstractmethod
    def project(self, normal: Numbers, tangential: Numbers) -> tuple[Numbers, Numbers]:
        """The nearest force that the contact can bear [N]."""

    @abstractmethod
    def support(self, opening: Numbers, sliding: Numbers, press: Numbers = inf) -> Numbers:
        """The greatest power that forces can take from a slip [W], if none presses with more than `press` [N]."""

    def spare(self, normal: Numbers, tangential: Numbers) -> Numbers:
        """How far inside the set a force is, by its normal part or by friction [N]; negative outside."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and what load cores prove needs none

        return np.minimum(normal - self.least_normal, self.greatest_friction(normal) - tangential)

    def violation(self, normal: Numbers, tangential: Numbers) -> Numbers:
        """By how much a force is outside the set [N]; 0 inside and on its border."""
        spare = self.spare(normal, tangential)
        return (abs(spare) - spare) / 2.0

    def interior(self, normal: Numbers, tangential: Numbers) -> Numbers:
        """Whether a force is inside the set, and not on its border."""
        return self.spare(normal, tangential) > 0.0

    def shortfall(self, opening: Numbers, sliding: Numbers) -> Numbers:
        """By how much a slip opens the contact too slowly [m/s], as `lift` says; negative if it opens it faster."""
        return self.lift(sliding) - opening

    def with_friction(self, friction: float) -> Self:
        """The same law with another coefficient."""
        return replace(self, friction=friction)


@dataclass(frozen=True, slots=True)
class Coulomb(ContactLaw):
    """Dry friction: the contact pushes, and friction is at most so many times the push; it never pulls."""

    is_cone = True
    least_normal = 0.0

    def greatest_friction(self, normal: Numbers) -> Numbers:
        """So many times the push."""
        return self.friction * normal

    def lift(self, sliding: Numbers) -> Numbers:
        """The slope of the steepest force, on which a body slides up at no cost."""
        return self.friction * sliding

    def project(self, normal: Numbers, tangential: Numbers) -> tuple[Numbers, Numbers]:
        """The force itself, the foot of the perpendicular on the border, or none."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and what load cores prove needs none

        pressed = np.maximum((normal + self.friction * tangential) / (1.0 + self.friction * self.friction), 0.0)
        inside = (tangential <= self.friction * normal) & (normal >= 0.0)
        return np.where(inside, normal, pressed), np.where(inside, tangential, self.friction * pressed)

    def projection(self, forces: Numbers) -> tuple[Numbers, Numbers]:
        """The nearest (n, 3) of forces by their normal and two tangential parts, and the derivatives (n, 3, 3)."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and what load cores prove needs none

        normal, tangential = forces[:, 0], np.hypot(forces[:, 1], forces[:, 2])
        size, slope = np.where(tangential > 0.0, tangential, 1.0), self.friction + np.zeros(len(forces))
        pressed, rubbed = self.project(normal, tangential)
        along = forces[:, 1:] / size[:, None]
        aside = np.column_stack([-along[:, 1], along[:, 0]])
        edge = np.column_stack([np.ones(len(forces)), slope[:, None] * along])
        turned = edge[:, :, None] * edge[:, None, :] / (1.0 + slope * slope)[:, None, None]
        turned[:, 1:, 1:] += (rubbed / size)[:, None, None] * aside[:, :, None] * aside[:, None, :]
        turned[self.spare(normal, tangential) >= 0.0] = np.identity(3)
        turned[pressed == 0.0] = 0.0
        return np.column_stack([pressed, rubbed[:, None] * along]), turned

    def support(self, opening: Numbers, sliding: Numbers, press: Numbers = inf) -> Numbers:
        """None from a slip that opens the contact fast enough; else all that the push allows."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and what load cores prove needs none

        short = np.maximum(self.shortfall(opening, sliding), 0.0)
        return np.multiply(press, short, out=np.zeros_like(short), where=short > 0.0)


# Coulomb coefficients by body, by kind of body, and by pair.
#
# Two surfaces meet in every contact. What is known of the pair itself counts first; else each has a coefficient of its
# own, and a rule makes one of two, by default the lower. Every rule gives two surfaces that are alike what each of them
# has, so that bodies without a coefficient of their own have the usual one on each other.


MOST_TIMES: Final = 1e300  # what coefficients are multiplied by, at most

Kind: TypeAlias = str  # of bodies: those of one kind have one surface


class Rule(StrEnum):
    """How one coefficient is made of those of two surfaces."""

    LOWER = "lower"
    HIGHER = "higher"
    MEAN = "mean"
    GEOMETRIC = "geometric"  # the root of their product


_RULES: Final[Mapping[Rule, Callable[[float, float], float]]] = {
    Rule.LOWER: min,
    Rule.HIGHER: max,
    Rule.MEAN: lambda one, other: 0.5 * (one + other),
    # Of two that are alike, that very number; and no product that is out of range.
    Rule.GEOMETRIC: lambda one, other: one if one == other else sqrt(one) * sqrt(other),
}


_SUCH_AS: Final = {
    "own": "{'sheet': 0.2}",
    "between": "{('sheet', 'carton'): 0.3}",
    "kinds": "{'L1.1': 'sheet'}",
}  # of each mapping of a law


@dataclass(frozen=True, slots=True)
class Surface:
    """What is known of how a brick rubs; two of one surface rub alike on any other body."""

    own: float | None  # Coulomb coefficient
    kind: Kind | None  # where something is said of pairs with this kind
    body: BodyId | None  # where something is said of pairs with this brick itself


@dataclass(frozen=True, slots=True)
class Friction:
    """The Coulomb coefficients of a scene.

    Names are those of bodies or of kinds; what is said of a body itself counts before what is said of its kind.
    """

    usual: float  # of bricks that have none of their own, on each other
    own: Mapping[BodyId | Kind, float] = field(default_factory=dict)
    # In any order; of a kind with itself for two of its bodies.
    between: Mapping[tuple[BodyId | Kind, BodyId | Kind], float] = field(default_factory=dict)
    kinds: Mapping[BodyId, Kind] = field(default_factory=dict)  # of what has one; it may grow as bodies come
    rule: Rule = Rule.LOWER

    def __post_init__(self) -> None:
        """Refuse what is no law. What coefficients mean is asked where the law comes to count."""
        admit_number("the usual friction is", self.usual, "write a coefficient of 0 or more")
        for what, given in (("own", self.own), ("between", self.between), ("kinds", self.kinds)):
            if not isinstance(given, Mapping):
                raise TypeError(f"`{what}` of a Friction is {told(given)}; write a mapping, such as {_SUCH_AS[what]}")

    @property
    def differs(self) -> bool:
        """Whether more is said of bricks than what is usual."""
        return bool(self.own or self.between)

    @property
    def most(self) -> float:
        """The largest coefficient of all that are said."""
        return max(self.usual, *self.own.values(), *self.between.values(), 0.0)

    def of(self, one: BodyId, other: BodyId) -> float:
        """The coefficient of two bricks on each other."""
        if not self.differs:
            return self.usual
        pair = self._between(one, other)
        return self._of_two(self._own(one), self._own(other), self.usual) if pair is None else pair

    def on(self, brick: BodyId, plane: Plane) -> float:
        """The coefficient of a brick on a plane: a brick without one of its own has that of the plane there."""
        if not isinstance(plane, Plane):
            raise TypeError(f"expected Plane(name, point, normal, friction), not {told(plane)}")
        if not self.differs:
            return plane.friction
        pair = self._between(brick, plane.id)
        return self._of_two(self._own(brick), plane.friction, plane.friction) if pair is None else pair

    def times(self, factor: float) -> "Friction":
        """The same, with every coefficient so many times as large."""
        admit_in_range("the factor is", factor, 0.0, MOST_TIMES, f"write a number from 0 to {MOST_TIMES:g}")
        return replace(
            self,
            usual=factor * self.usual,
            own={name: factor * own for name, own in self.own.items()},
            between={pair: factor * each for pair, each in self.between.items()},
        )

    def surface_of(self, brick: BodyId) -> "Surface":
        """What a brick has in common with all that rub on others as it does."""
        named = {name for pair in self.between for name in pair}
        kind = self.kinds.get(brick)
        return Surface(self._own(brick), kind if kind in named else None, brick if brick in named else None)

    def _own(self, body: BodyId) -> float | None:
        own = self.own.get(body)
        return self.own.get(self.kinds.get(body, body)) if own is None else own

    def _of_two(self, one: float | None, other: float | None, usual: float) -> float:
        if one is None and other is None:
            return usual
        return _RULES[self.rule](usual if one is None else one, usual if other is None else other)

    def _between(self, one: BodyId, other: BodyId) -> float | None:
        """What is said of a pair: of two bodies first, then of one and the kind of the other, then of two kinds."""
        if not self.between:
            return None
        a, b = self.kinds.get(one), self.kinds.get(other)
        for pairs in (((one, other),), ((one, b), (a, other)), ((a, b),)):
            found = [
                each for x, y in pairs if x is not None and y is not None and (each := self._said(x, y)) is not None
            ]
            if found:
                return min(found)
        return None

    def _said(self, one: str, other: str) -> float | None:
        said = self.between.get((one, other))
        return self.between.get((other, one)) if said is None else said


GivenFriction: TypeAlias = float | Friction


def as_friction(friction: GivenFriction) -> Friction:
    """The law of one coefficient for all, or the one that is given."""
    return friction if isinstance(friction, Friction) else Friction(friction)


def admit_friction(friction: GivenFriction) -> None:
    """Raise ValueError for coefficients that mean nothing, TypeError for what is none."""
    if not isinstance(friction, Friction):
        return _admit("the friction is", friction)
    for what, coefficient in _said_by(friction):
        _admit(what, coefficient)
    for name, kind in friction.kinds.items():
        if not isinstance(name, str) or not isinstance(kind, str):
            raise TypeError(f"{told(name)} is of the kind {told(kind)}; write names as texts")
    if not isinstance(friction.rule, Rule):
        raise TypeError(f"the rule of friction is {told(friction.rule)}; write one of {', '.join(map(str, Rule))}")
    for one, other in friction.between:
        if friction.between[one, other] != friction.between.get((other, one), friction.between[one, other]):
            raise ValueError(f"there are two frictions between '{one}' and '{other}'; give one")


def _said_by(friction: Friction) -> Iterator[tuple[str, float]]:
    yield "the friction is", friction.usual
    yield from ((f"'{name}' has the friction", own) for name, own in friction.own.items())
    for pair, between in friction.between.items():
        if not (isinstance(pair, tuple) and len(pair) == 2 and all(isinstance(name, str) for name in pair)):  # noqa: PLR2004
            raise TypeError(f"expected a pair of names, such as ('sheet', 'carton'), not {told(pair)}")
        yield f"between '{pair[0]}' and '{pair[1]}' the friction is", between


def _admit(what: str, coefficient: float) -> None:
    admit_number(what, coefficient, "write a coefficient of 0 or more")
    if not 0.0 <= coefficient < float("inf"):
        raise ValueError(f"{what} {told(coefficient)}; it is 0 or more")
