"""Limits of a number with which a case stands, and the sensitivities of its margin, for programs."""

from stackdsl.checking.cases import Case
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
    """Find the limit of a number of one case, as `stackdsl find` does, without playing the case.

    One of `largest`, `least` and `most` names the number. `from_` and `to` are values as authors write them, such as "5
    mm"; `within` is the accepted relative distance of both sides of a limit, and `bearing` [rad] is that of a tilt or
    an acceleration. Raises SearchError, a ValueError, for a name without a limit.
    """
    given = [(want, name) for want, name in zip(Want, (largest, least, most), strict=True) if name is not None]
    if len(given) != 1:
        raise TypeError("say one of largest, least and most, such as largest='step'")
    if not FINEST <= within <= 1.0:
        raise ValueError(f"within is a share of the limit, from {FINEST:g} to 1, not {within!r}")
    ((want, name),) = given
    return find_in(case, case.name, LimitRequest(want, name, from_, to, within, bearing))


def sensitivities(case: Case, of: str = MarginKind.ACCELERATION, check: int = CHECKED) -> Sensitivities:
    """Compute the sensitivities of the margin of one case, the largest first, as `stackdsl sensitivities` does.

    `of` is "acceleration" or "friction"; `check` is the number of sensitivities that are compared with differences.
    Raises SearchError, a ValueError, for a case without such a margin.
    """
    return sensitivities_of(case, case.name, MarginKind(of), check)
