"""The largest or the least number with which a case stands, and what its margin depends on, for programs."""

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
    """What `stackdsl find` finds of one case, which is not played.

    One of `largest`, `least` and `most` names the number. `from_` and `to` are values as authors write them, such as
    "5 mm"; `within` is the share by which both sides of a limit may be apart, and `bearing` [rad] is that of a tilt or
    an acceleration. Raises SearchError, a ValueError, where no limit can be asked of what is called so.
    """
    given = [(want, name) for want, name in zip(Want, (largest, least, most), strict=True) if name is not None]
    if len(given) != 1:
        raise TypeError("say one of largest, least and most, such as largest='step'")
    if not FINEST <= within <= 1.0:
        raise ValueError(f"within is a share of the limit, from {FINEST:g} to 1, not {within!r}")
    ((want, name),) = given
    return find_in(case, case.name, LimitRequest(want, name, from_, to, within, bearing))


def sensitivities(case: Case, of: str = MarginKind.ACCELERATION, check: int = CHECKED) -> Sensitivities:
    """What `stackdsl sensitivities` tells of one case: on what its margin depends, the most first.

    `of` is "acceleration" or "friction"; `check` says how many are held against differences. Raises SearchError, a
    ValueError, for what has no such margin.
    """
    return sensitivities_of(case, case.name, MarginKind(of), check)
