"""Finds the largest or least value with which a case stands, and the sensitivities of its margin."""

from typing import Final

from stability.notebook import Display, display_of
from stackdsl.api.notebook import lines_display
from stackdsl.checking.cases import Case
from stackdsl.report.studies import limit_lines, sensitivity_lines
from stackdsl.studies.find_limit import ACCURACY, FINEST, FoundLimit, LimitRequest, SearchError, Want, find_in
from stackdsl.studies.sensitivities import CHECKED, MarginKind, Sensitivities, sensitivities_of

__all__ = ["FoundLimit", "SearchError", "Sensitivities", "find", "sensitivities"]


def find(
    case: Case,
    *,
    largest: str | None = None,
    least: str | None = None,
    most: str | None = None,
    from_: str = "",
    to: str = "",
    within: float = ACCURACY,
    bearing: float | None = None,
) -> FoundLimit:
    """Find the limit of one number of a case, like `stackdsl find`, without simulation.

    Exactly one of `largest`, `least` and `most` (the largest whole number) is the name of the number. `from_` and `to`
    are the ends of the search, as in YAML, such as "5 mm". `within` is the relative distance of both sides of the
    limit. `bearing` is the direction of a tilt or an acceleration [rad].

    Raises SearchError, a ValueError, if the case has no number of this name, or no limit of it can be searched for.
    """
    requested = [(want, name) for want, name in zip(Want, (largest, least, most), strict=True) if name is not None]
    if len(requested) != 1:
        raise TypeError("find needs exactly one of largest, least and most, such as largest='step'")
    if not FINEST <= within <= 1.0:
        raise ValueError(f"within must be from {FINEST:g} to 1, as a share of the limit, not {within!r}")
    ((want, name),) = requested
    return find_in(case, case.name, LimitRequest(want, name, from_, to, within, bearing))


def sensitivities(case: Case, of: str = MarginKind.ACCELERATION, check: int = CHECKED) -> Sensitivities:
    """Return the effects of all numbers of a case on its margin, the largest first, like `stackdsl sensitivities`.

    `of` is "acceleration" or "friction". `check` is the number of effects that are verified by finite differences.

    Raises SearchError, a ValueError, if the case has no such margin.
    """
    return sensitivities_of(case, case.name, MarginKind(of), check)


MOST: Final = 20  # effects that a notebook shows


@display_of.register
def _(found: FoundLimit) -> Display:
    return lines_display(limit_lines(found))


@display_of.register
def _(found: Sensitivities) -> Display:
    return lines_display(sensitivity_lines(found, MOST))
