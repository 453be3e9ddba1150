"""How rough bodies are on each other: Coulomb coefficients by body, by kind of body, and by pair.

Two surfaces meet in every contact. What is known of the pair itself counts first; else each has a coefficient of its
own, and a rule makes one of two, by default the lower. Every rule gives two surfaces that are alike what each of them
has, so that bodies without a coefficient of their own have the usual one on each other.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import sqrt
from typing import Final, TypeAlias

from stability.geometry.vectors import admit_in_range, admit_number, told
from stability.model import BodyId, Plane

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


def law_of(friction: GivenFriction) -> Friction:
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
