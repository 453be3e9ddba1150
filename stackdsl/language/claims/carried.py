"""The claims `load` and `pressure`: proven forces on bricks and between them."""

from abc import abstractmethod
from collections.abc import Collection, Iterator
from math import inf
from typing import ClassVar, Final, Self

from pydantic import Field, model_validator

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, remaining, within
from stackdsl.language.claims.margin import unproven_text
from stackdsl.language.model_base import Shorthand
from stackdsl.language.quantities import InputError
from stackdsl.language.tolerances import MassTolerance, Tolerance
from stackdsl.trace import ALL_LOADS, BrickState, CarriedRange, Trace, load_on
from stackdsl.wording import significant

EXACT: Final = 1e-6  # share of a limit: proven bounds that differ from it by less count as equal to it

SAME: Final = 1e-4  # share of a load: a narrower range is told as one number


class CarriedClaim(Shorthand, ClaimKind):
    """A load on bricks, or of one brick on another: a range in which all possible values must lie."""

    bricks: t.BodyNames | None = Field(None, description="bricks on which others lie; default: all")
    support: t.BodyOrPlaneName | None = Field(None, description="one brick, or `ground`, on which others lie")
    brick: t.BodyName | None = Field(None, description="of what lies on `support`, this brick only")

    scalar_key: ClassVar[str] = "is"
    identifying_keys: ClassVar[tuple[str, ...]] = ("bricks", "support", "brick")
    needs_statics: ClassVar[bool] = True

    @model_validator(mode="after")
    def _name_one_place(self) -> Self:
        if self.bricks is not None and (self.support is not None or self.brick is not None):
            raise InputError("SD102", "`bricks` excludes `support` and `brick`", "write two claims")
        if self.brick is not None and self.support is None:
            raise InputError("SD102", "`brick` needs the body under it", "add `support`, such as support: ground")
        return self

    @property
    def needed_margins(self) -> Collection[str]:
        if self.support is not None:
            return (load_on(self.support, self.brick or ""),)
        return (ALL_LOADS,) if self.bricks is None else tuple(map(load_on, self.bricks))

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the proven range of each place, which has to lie in the tolerance."""
        bricks = remaining(trace)
        lost = [name for name, track in bricks if track.state is BrickState.FALLEN or not track.frozen]
        if lost:
            return ClaimResult(unproven_text("no load is proven", lost, bricks, trace), -inf, "", passed=False)
        results = [result for each in self._ranges(trace) for result in self._compared(each, trace)]
        if not results:
            measured = "no load is proven" if self.brick is None else "the brick does not lie on this support"
            return ClaimResult(measured, -inf, "", passed=False)
        return min(results, key=lambda result: (result.passed, result.margin))

    def _ranges(self, trace: Trace) -> Iterator[CarriedRange]:
        names = None if self.bricks is None else frozenset(self.bricks)
        for each in trace.margins.carried:
            if self.support is not None:
                if (each.lower, each.upper) == (self.support, self.brick or ""):
                    yield each
            elif each.upper == "" and (each.lower in trace.tracks if names is None else each.lower in names):
                yield each

    def _compared(self, each: CarriedRange, trace: Trace) -> Iterator[ClaimResult]:
        wanted, least, greatest, unit, scale = self._values(each, trace)
        where = f"on {each.lower}" + (f" by {each.upper}" if each.upper else "")
        low, high = (significant(scale * value) for value in (least, greatest))
        if greatest < inf and greatest - least <= SAME * greatest:
            low = high
        upwards = "or more, without limit," if greatest == inf else f"to {high} {unit}"  # as friction may wedge a brick
        measured = f"{low} {unit} {where}" if low == high else f"{low} {unit} {upwards} {where}"
        for value in (least, greatest):
            yield within(wanted, _at_limit(value, wanted), unit, measured)

    @abstractmethod
    def _values(self, each: CarriedRange, trace: Trace) -> tuple[Tolerance, float, float, str, float]:
        """Return the tolerance, both proven bounds in its SI unit, the unit of reports, and its number per SI unit."""


def _at_limit(value: float, wanted: Tolerance) -> float:
    """Return the limit that a bound equals but for rounding, or the bound."""
    return next((limit for limit in (wanted.low, wanted.high) if abs(value - limit) <= EXACT * abs(limit) < inf), value)


@claim("load", "proven load on bricks, whichever way the forces take")
class LoadClaim(CarriedClaim):
    """The sum of the normal forces by which others lie on a brick, of all forces that the contacts can bear."""

    within: t.WeightTolerance = Field(alias="is", description="accepted loads, as a mass or a force")

    def contradicts(self, other: Self) -> bool:
        return isinstance(self.within, MassTolerance) == isinstance(
            other.within, MassTolerance
        ) and super().contradicts(other)

    def _values(self, each: CarriedRange, trace: Trace) -> tuple[Tolerance, float, float, str, float]:
        if isinstance(self.within, MassTolerance):
            gravity = trace.world.gravity if trace.world is not None else inf
            return self.within, each.least / gravity, each.greatest / gravity, "kg", 1.0
        return self.within, each.least, each.greatest, "N", 1.0


@claim("pressure", "proven mean pressure on bricks, whichever way the forces take")
class PressureClaim(CarriedClaim):
    """The load on a brick over the area of the faces on which it lies."""

    within: t.PressureTolerance = Field(alias="is", description="accepted mean pressures")

    def _ranges(self, trace: Trace) -> Iterator[CarriedRange]:
        yield from (each for each in super()._ranges(trace) if each.area > 0.0 or each.greatest == 0.0)

    def _values(self, each: CarriedRange, _trace: Trace) -> tuple[Tolerance, float, float, str, float]:
        area = each.area or 1.0
        return self.within, each.least / area, each.greatest / area, "kPa", 1e-3
