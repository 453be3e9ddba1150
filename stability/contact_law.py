"""The law of a contact: the admissible forces at a point, and the coefficient of friction of two bodies.

Only `Contact.law` defines the set of forces. The checks of proofs use its methods, so they hold for any law. Verdicts
and load factors support any law with `borders`; margins against acceleration a Coulomb cone with its tip anywhere on
the normal (`is_shifted_cone`); initial motions, their uniqueness and placement errors support `Coulomb` only, and
refuse other laws (`coulomb_coefficients`).

A set with bounded forces is a sum of two: of the forces that it bears of any size, which are a cone (`unbounded`), and
of a bounded set. Proofs may be added as long as all but one of them use forces of the cone only.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from enum import StrEnum
from math import inf, sqrt
from typing import Any, ClassVar, Final, Self, TypeAlias

from stability.geometry.vectors import admit_in_range, admit_number, short_repr
from stability.model import BodyId, Plane

# The forces that a contact can bear at one of its points: a convex set with rotational symmetry about the normal.
#
# By symmetry a force is described by its normal component and its tangential size, and a slip by its opening and
# sliding speeds. A force is that of the lower body on the upper one; a slip is the velocity of the upper body relative
# to the lower one.


Numbers: TypeAlias = Any  # a number, or an array with one entry per point: the same arithmetic holds for both


@dataclass(frozen=True, slots=True)
class ContactLaw(ABC):
    """Forces that a contact can bear at a point.

    Its fields are numbers that are not negative. Fields, arguments and results may be arrays with one entry per point:
    then it is the law of many points at once.
    """

    # True if the set contains all sums of its forces. Otherwise proofs with this law must not be added.
    is_cone: ClassVar[bool]
    # True if the set is a Coulomb cone with its tip at `least_normal`.
    is_shifted_cone: ClassVar[bool] = False

    friction: Numbers  # Coulomb coefficient: increase of the greatest friction per normal force

    @property
    @abstractmethod
    def least_normal(self) -> Numbers:
        """Return the least normal force [N]; negative if the contact can pull."""

    @property
    @abstractmethod
    def borders(self) -> tuple[tuple[Numbers, Numbers], ...]:
        """Return lines over the normal force, as intercept [N] and slope: friction is at most the least of them."""

    @property
    @abstractmethod
    def unbounded(self) -> "Coulomb":
        """Return the cone of forces that the contact bears multiplied by any factor, also added to any other force."""

    @abstractmethod
    def smooth(self) -> Self:
        """Return the law of the same contact without friction that grows with the normal force."""

    @abstractmethod
    def greatest_friction(self, normal: Numbers) -> Numbers:
        """Return the greatest tangential force at a normal force [N]."""

    @abstractmethod
    def lift(self, sliding: Numbers) -> Numbers:
        """Return the opening speed above which contact forces take only bounded power from a slip [m/s]."""

    @abstractmethod
    def project(self, normal: Numbers, tangential: Numbers) -> tuple[Numbers, Numbers]:
        """Return the nearest force that the contact can bear [N]."""

    @abstractmethod
    def support(self, opening: Numbers, sliding: Numbers, press: Numbers = inf) -> Numbers:
        """Return the greatest power that forces take from a slip [W], for normal forces up to `press` [N]."""

    def spare(self, normal: Numbers, tangential: Numbers) -> Numbers:
        """Return the distance of a force from the set's border, normal or tangential [N]; negative outside."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        return np.minimum(normal - self.least_normal, self.greatest_friction(normal) - tangential)

    def is_sound(self) -> bool:
        """Return whether all numbers of the law are finite and not negative."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        numbers = [getattr(self, each.name) for each in fields(self)]
        return all(bool((np.isfinite(each) & (np.asarray(each) >= 0.0)).all()) for each in numbers)

    def violation(self, normal: Numbers, tangential: Numbers) -> Numbers:
        """Return the distance of a force outside the set [N]; 0 inside and on its border."""
        spare = self.spare(normal, tangential)
        return (abs(spare) - spare) / 2.0

    def interior(self, normal: Numbers, tangential: Numbers) -> Numbers:
        """Return whether a force is inside the set and not on its border."""
        return self.spare(normal, tangential) > 0.0

    def shortfall(self, opening: Numbers, sliding: Numbers) -> Numbers:
        """Return the difference of `lift` and the opening speed of a slip [m/s]; negative if the slip opens faster."""
        return self.lift(sliding) - opening

    def with_friction(self, friction: float) -> Self:
        """Return the same law with another coefficient."""
        return replace(self, friction=friction)


@dataclass(frozen=True, slots=True)
class Coulomb(ContactLaw):
    """Dry friction: the contact never pulls, and friction is at most the coefficient times the normal force."""

    is_cone = True
    is_shifted_cone = True
    least_normal = 0.0

    @property
    def borders(self) -> tuple[tuple[Numbers, Numbers], ...]:
        """Return the side of the cone."""
        return ((0.0 * self.friction, self.friction),)

    @property
    def unbounded(self) -> "Coulomb":
        """Return the law itself."""
        return self

    def smooth(self) -> "Coulomb":
        """Return the law with a coefficient of zero."""
        return self.with_friction(0.0)

    def greatest_friction(self, normal: Numbers) -> Numbers:
        """Return the coefficient times the normal force."""
        return self.friction * normal

    def lift(self, sliding: Numbers) -> Numbers:
        """Return the opening speed of a slip along the steepest force of the cone, which takes no power."""
        return self.friction * sliding

    def project(self, normal: Numbers, tangential: Numbers) -> tuple[Numbers, Numbers]:
        """Return the force itself, the foot of the perpendicular on the border, or zero."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        pressed = np.maximum((normal + self.friction * tangential) / (1.0 + self.friction * self.friction), 0.0)
        inside = (tangential <= self.friction * normal) & (normal >= 0.0)
        return np.where(inside, normal, pressed), np.where(inside, tangential, self.friction * pressed)

    def projection(self, forces: Numbers) -> tuple[Numbers, Numbers]:
        """Return the nearest forces and their derivatives (n, 3, 3).

        Each row of `forces` (n, 3) has the normal and two tangential components of a force.
        """
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

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
        """Return zero for a slip that opens the contact fast enough, otherwise the power that `press` allows."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        short = np.maximum(self.shortfall(opening, sliding), 0.0)
        return np.multiply(press, short, out=np.zeros_like(short), where=short > 0.0)


@dataclass(frozen=True, slots=True)
class MohrCoulomb(ContactLaw):
    """A joint that pulls: Mohr and Coulomb's law with a cut-off of tension, and a bound of shear.

    Friction is at most `cohesion` plus the coefficient times the normal force, and never more than `shear`.
    """

    is_cone = False

    tension: Numbers  # [N] greatest pull
    cohesion: Numbers  # [N] greatest friction without normal force
    shear: Numbers = inf  # [N] greatest friction at any normal force; inf for no such bound

    @property
    def least_normal(self) -> Numbers:
        """Return the pull, which ends where no friction is left."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        friction, cohesion = np.asarray(self.friction, dtype=float), np.asarray(self.cohesion, dtype=float)
        tip = np.divide(cohesion, friction, out=np.full(np.shape(friction + cohesion), inf), where=friction > 0.0)
        return -np.minimum(self.tension, tip)

    @property
    def borders(self) -> tuple[tuple[Numbers, Numbers], ...]:
        """Return the line of Mohr and Coulomb, and the bound of shear."""
        return (self.cohesion, self.friction), (self.shear, 0.0 * self.friction)

    @property
    def unbounded(self) -> Coulomb:
        """Return the cone of Coulomb, or the normal alone if shear is bounded."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        slope = np.where(np.isinf(self.shear), self.friction, 0.0)
        return Coulomb(slope if slope.ndim else float(slope))

    def times(self, factor: float) -> "MohrCoulomb":
        """Return the law with all strengths multiplied."""
        return MohrCoulomb(self.friction, factor * self.tension, factor * self.cohesion, factor * self.shear)

    def smooth(self) -> "MohrCoulomb":
        """Return the law with friction up to the cohesion only."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        return replace(self, shear=np.minimum(self.shear, self.cohesion))

    def is_sound(self) -> bool:
        """Return whether the numbers are not negative, and finite except for the bound of shear."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        finite = np.where(np.isinf(self.shear), 0.0, self.shear)
        return ContactLaw.is_sound(replace(self, shear=finite))

    def greatest_friction(self, normal: Numbers) -> Numbers:
        """Return the cohesion and the friction of the normal force, up to the bound of shear."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        return np.minimum(self.cohesion + self.friction * normal, self.shear)

    def lift(self, sliding: Numbers) -> Numbers:
        """Return the opening speed of a slip along the steepest force; zero if shear is bounded."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        return np.where(np.isinf(self.shear), self.friction, 0.0) * sliding

    def _corners(self) -> tuple[Numbers, Numbers, Numbers, Numbers]:
        """Return the least normal force with its greatest friction, and the point where the bound of shear begins.

        The second point is infinitely far away if shear is not bounded.
        """
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        least = np.asarray(self.least_normal, dtype=float)
        low = np.maximum(self.greatest_friction(least), 0.0)
        slope, height = np.broadcast_arrays(np.asarray(self.friction, dtype=float), np.asarray(self.shear - low))
        flat = np.where(height > 0.0, np.where(slope > 0.0, inf, 0.0), 0.0)
        rise = np.divide(height, slope, out=flat.astype(float), where=(slope > 0.0) & (height > 0.0) & (height < inf))
        return least, low, least + rise, np.where(slope > 0.0, np.maximum(self.shear, low), low)

    def project(self, normal: Numbers, tangential: Numbers) -> tuple[Numbers, Numbers]:
        """Return the force itself, or the nearest point of the three sides of the set."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        least, low, start, high = self._corners()
        friction = self.friction + np.zeros(np.shape(start))
        share = np.clip(
            (normal - least + friction * (tangential - low)) / (1.0 + friction * friction), 0.0, start - least
        )
        bounded = np.isfinite(start)
        sides = [
            (least + 0.0 * normal, np.clip(tangential, 0.0, low)),
            (least + share, low + friction * share),
            (np.where(bounded, np.maximum(normal, start), inf), np.where(bounded, high, 0.0) + 0.0 * normal),
        ]
        nearest_n, nearest_t = sides[0]
        for n, t in sides[1:]:
            nearer = (n - normal) ** 2 + (t - tangential) ** 2 < (nearest_n - normal) ** 2 + (
                nearest_t - tangential
            ) ** 2
            nearest_n, nearest_t = np.where(nearer, n, nearest_n), np.where(nearer, t, nearest_t)
        inside = self.spare(normal, tangential) >= 0.0
        return np.where(inside, normal, nearest_n), np.where(inside, tangential, nearest_t)

    def support(self, opening: Numbers, sliding: Numbers, press: Numbers = inf) -> Numbers:
        """Return the power at the corner of the set that takes most, and beyond it what `press` allows."""
        import numpy as np  # noqa: PLC0415 -- slow to import, and proofs by load cores do not need it

        least, low, start, high = self._corners()
        most = np.maximum(-least * opening, low * sliding - least * opening)
        within = np.isfinite(start) & (start <= press)
        corner = np.where(within, high, 0.0) * sliding - np.where(within, start, 0.0) * opening
        most = np.maximum(most, np.where(within, corner, -inf))
        short = self.shortfall(opening, sliding) > 0.0
        pressed = np.where(np.isinf(press), 0.0, press)
        far = self.greatest_friction(pressed) * sliding - pressed * opening
        return np.where(short, np.where(np.isinf(press), inf, np.maximum(most, far)), most)


class OtherLawError(NotImplementedError):
    """An analysis does not support the law of a contact."""


def coulomb_coefficients(laws: Iterable[ContactLaw]) -> list[float]:
    """Return the coefficients of Coulomb's laws. Raises OtherLawError for any other law."""
    coefficients = []
    for law in laws:
        if not isinstance(law, Coulomb):
            raise OtherLawError(f"this analysis supports dry friction only, not {type(law).__name__}")
        coefficients.append(law.friction)
    return coefficients


# Coulomb coefficients by body, by kind of body, and by pair.
#
# Every contact is between two surfaces. A coefficient of the pair counts first; otherwise each surface has its own
# coefficient, and a rule combines both, by default the lower one. Every rule gives two equal surfaces their own
# coefficient, so that bodies without one of their own have the usual coefficient on each other.


MOST_TIMES: Final = 1e300  # largest factor on coefficients

Kind: TypeAlias = str  # bodies of one kind have the same surface


class Rule(StrEnum):
    """Rule that combines the coefficients of two surfaces."""

    LOWER = "lower"
    HIGHER = "higher"
    MEAN = "mean"
    GEOMETRIC = "geometric"  # the square root of their product


_RULES: Final[Mapping[Rule, Callable[[float, float], float]]] = {
    Rule.LOWER: min,
    Rule.HIGHER: max,
    Rule.MEAN: lambda one, other: 0.5 * (one + other),
    # Two equal coefficients give exactly this number, and no product leaves the range of floats.
    Rule.GEOMETRIC: lambda one, other: one if one == other else sqrt(one) * sqrt(other),
}


_SUCH_AS: Final = {
    "own": "{'sheet': 0.2}",
    "between": "{('sheet', 'carton'): 0.3}",
    "kinds": "{'L1.1': 'sheet'}",
}  # for each mapping of a law


@dataclass(frozen=True, slots=True)
class Surface:
    """Friction of a brick: two bricks with equal surfaces have the same friction on any other body."""

    own: float | None  # Coulomb coefficient
    kind: Kind | None  # only if a pair names this kind
    body: BodyId | None  # only if a pair names this brick


@dataclass(frozen=True, slots=True)
class Friction:
    """Coulomb coefficients of a scene.

    Names are those of bodies or of kinds; an entry for a body takes precedence over one for its kind.
    """

    usual: float  # of two bricks without a coefficient of their own
    own: Mapping[BodyId | Kind, float] = field(default_factory=dict)
    # In any order; a kind with itself for two bodies of the kind.
    between: Mapping[tuple[BodyId | Kind, BodyId | Kind], float] = field(default_factory=dict)
    # of bodies with a kind; entries may be added with new bodies
    kinds: Mapping[BodyId, Kind] = field(default_factory=dict)
    rule: Rule = Rule.LOWER

    def __post_init__(self) -> None:
        """Raise for invalid types. `admit_friction` checks the coefficients when the law is used."""
        admit_number("`usual` of the Friction is", self.usual, "write a coefficient of at least 0")
        for what, entries in (("own", self.own), ("between", self.between), ("kinds", self.kinds)):
            if not isinstance(entries, Mapping):
                raise TypeError(
                    f"`{what}` of a Friction is {short_repr(entries)}; write a mapping, such as {_SUCH_AS[what]}"
                )

    @property
    def differs(self) -> bool:
        """Return whether any body or pair has a coefficient other than the usual one."""
        return bool(self.own or self.between)

    @property
    def most(self) -> float:
        """Return the largest coefficient of the law."""
        return max(self.usual, *self.own.values(), *self.between.values(), 0.0)

    def of(self, one: BodyId, other: BodyId) -> float:
        """Return the coefficient of two bricks on each other."""
        if not self.differs:
            return self.usual
        pair = self._between(one, other)
        return self._of_two(self._own(one), self._own(other), self.usual) if pair is None else pair

    def on(self, brick: BodyId, plane: Plane) -> float:
        """Return the coefficient of a brick on a plane; a brick without its own takes that of the plane."""
        if not isinstance(plane, Plane):
            raise TypeError(f"expected Plane(name, point, normal, friction), not {short_repr(plane)}")
        if not self.differs:
            return plane.friction
        pair = self._between(brick, plane.id)
        return self._of_two(self._own(brick), plane.friction, plane.friction) if pair is None else pair

    def times(self, factor: float) -> "Friction":
        """Return the same law with every coefficient multiplied by a factor."""
        admit_in_range("the factor is", factor, 0.0, MOST_TIMES, f"write a number from 0 to {MOST_TIMES:g}")
        return replace(
            self,
            usual=factor * self.usual,
            own={name: factor * own for name, own in self.own.items()},
            between={pair: factor * each for pair, each in self.between.items()},
        )

    def surface_of(self, brick: BodyId) -> "Surface":
        """Return the surface of a brick: all data that determine its friction on other bodies."""
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
        """Return the coefficient of a pair: of two bodies first, then of a body and a kind, then of two kinds."""
        if not self.between:
            return None
        a, b = self.kinds.get(one), self.kinds.get(other)
        for pairs in (((one, other),), ((one, b), (a, other)), ((a, b),)):
            coefficients = [
                each for x, y in pairs if x is not None and y is not None and (each := self._entry(x, y)) is not None
            ]
            if coefficients:
                return min(coefficients)
        return None

    def _entry(self, one: str, other: str) -> float | None:
        entry = self.between.get((one, other))
        return self.between.get((other, one)) if entry is None else entry


GivenFriction: TypeAlias = float | Friction


def as_friction(friction: GivenFriction) -> Friction:
    """Return a `Friction` unchanged, or the law with a single coefficient."""
    return friction if isinstance(friction, Friction) else Friction(friction)


def admit_friction(friction: GivenFriction) -> None:
    """Raise ValueError for invalid coefficients, TypeError for invalid types."""
    if not isinstance(friction, Friction):
        return _admit("the friction is", friction)
    for what, coefficient in _coefficients(friction):
        _admit(what, coefficient)
    for name, kind in friction.kinds.items():
        if not isinstance(name, str) or not isinstance(kind, str):
            raise TypeError(f"the kind of {short_repr(name)} is {short_repr(kind)}; write both names as strings")
    if not isinstance(friction.rule, Rule):
        raise TypeError(
            f"the rule of friction is {short_repr(friction.rule)}; write one of {', '.join(map(str, Rule))}"
        )
    for one, other in friction.between:
        if friction.between[one, other] != friction.between.get((other, one), friction.between[one, other]):
            raise ValueError(f"there are two friction coefficients between '{one}' and '{other}'; keep one of them")


def _coefficients(friction: Friction) -> Iterator[tuple[str, float]]:
    yield "the friction is", friction.usual
    yield from ((f"the friction of '{name}' is", own) for name, own in friction.own.items())
    for pair, between in friction.between.items():
        if not (isinstance(pair, tuple) and len(pair) == 2 and all(isinstance(name, str) for name in pair)):  # noqa: PLR2004
            raise TypeError(f"expected a pair of names, such as ('sheet', 'carton'), not {short_repr(pair)}")
        yield f"the friction between '{pair[0]}' and '{pair[1]}' is", between


def _admit(what: str, coefficient: float) -> None:
    admit_number(what, coefficient, "write a coefficient of at least 0")
    if not 0.0 <= coefficient < float("inf"):
        raise ValueError(f"{what} {short_repr(coefficient)}; it must be finite and at least 0")
