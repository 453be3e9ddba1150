"""Studies of one case by statics: limits of its numbers, survived accelerations, sensitivities."""

import re
from typing import Final

from stability.analysis.weakest import Apart
from stability.notebook import Display, display_of
from stackdsl.api.arguments import refuse_other_types, refuse_outside, with_remedy
from stackdsl.api.cases import OneCase, one_case
from stackdsl.api.notebook import lines_display
from stackdsl.judging.proofs import Survival
from stackdsl.report.statics import margin_texts
from stackdsl.report.studies import limit_lines, sensitivity_lines, survival_lines
from stackdsl.studies import survival
from stackdsl.studies.find_limit import ACCURACY, FINEST, FoundLimit, LimitRequest, Want, find_in
from stackdsl.studies.limit_search import SearchError
from stackdsl.studies.sensitivities import CHECKED, MarginKind, Sensitivities, sensitivities_of
from stackdsl.studies.survival import CaseMargins
from stackdsl.trace import VerdictMargins
from stackdsl.wording import joints_text, weakest_text

__all__ = [
    "CaseMargins",
    "FoundLimit",
    "SearchError",
    "Sensitivities",
    "Survival",
    "find",
    "margins",
    "sensitivities",
    "survive",
]


@with_remedy("name the number as largest=, least= or most=, such as find(case, largest='step')")
def find(
    case: OneCase,
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
    ((want, name),) = requested
    refuse_other_types(str, "the name of a number, such as 'step'", **{want.value: name})
    refuse_other_types(str, "a text with a unit, such as '5 mm'", from_=from_, to=to)
    refuse_outside("within", within, FINEST, 1.0)
    refuse_other_types(float | int | None, "a number of radians", bearing=bearing)
    known = one_case(case)
    return find_in(known, known.name, LimitRequest(want, name, from_, to, within, bearing))


@with_remedy("such as sensitivities(case, of='friction')")
def sensitivities(case: OneCase, of: str = MarginKind.ACCELERATION, check: int = CHECKED) -> Sensitivities:
    """Return the effects of all numbers of a case on its margin, the largest first, like `stackdsl sensitivities`.

    `of` is "acceleration", "friction" or "load_factor". `check` is the number of effects that are verified by finite
    differences.

    Raises SearchError, a ValueError, if the case has no such margin.
    """
    if of not in [*MarginKind]:
        raise ValueError(f"of must be 'acceleration', 'friction' or 'load_factor', not {of!r}")
    refuse_outside("check", check, 0, MOST_CHECKED, int)
    known = one_case(case)
    return sensitivities_of(known, known.name, MarginKind(of), check)


@with_remedy("such as margins(case)")
def margins(case: OneCase) -> CaseMargins:
    """Return the disturbances that a case survives, as numbers, as `stackdsl explain --margins` reports them.

    `acceleration` [g] in the worst direction, `tilt` [rad], `friction` (least coefficient) and `placement` [m]
    (position error that all bricks may have at once, each in its worst direction) are None for a structure that is
    not proven to stand; `why` then says why not. So a loop over a number needs no exception.
    """
    known = one_case(case)
    return survival.margins_in(known, known.name)


@with_remedy("such as survive(case, bearings=36)")
def survive(case: OneCase, *, bearings: int = survival.BEARINGS, accuracy: float = survival.ACCURACY) -> Survival:
    """Return the acceleration and tilt that a case survives, and the part that fails first, like `stackdsl survive`.

    `bearings` is the number of directions, evenly spaced; `accuracy` is relative. `worst` of the result has `survived`
    [g], `tilt` [rad] and `bearing` [rad] of the weakest of these directions; `along` has all of them, and `weakest` is
    the weakest spot over all directions. `notes` names the parts of the case that are not judged.

    Raises SearchError, a ValueError, if the case is not proven to stand.
    """
    refuse_outside("bearings", bearings, survival.FEWEST_BEARINGS, survival.MOST_BEARINGS, int)
    refuse_outside("accuracy", accuracy, survival.FINEST, survival.COARSEST)
    known = one_case(case)
    return survival.survive_in(known, known.name, bearings, accuracy)


MOST_CHECKED: Final = 100_000
MOST: Final = 20  # effects that a notebook shows


@display_of.register
def _(found: FoundLimit) -> Display:
    return lines_display(limit_lines(found))


@display_of.register
def _(found: Sensitivities) -> Display:
    lines = (line.replace("--check N", "check=N") for line in sensitivity_lines(found, MOST))
    return lines_display(re.sub(r"--top \d+ lists all", "`effects` of the result has all", line) for line in lines)


@display_of.register
def _(found: CaseMargins) -> Display:
    notes = [("note", note) for note in found.notes]
    if found.why:
        return Display(found.name, [("why", found.why), *notes], "\u2717 no margins", False)
    known = VerdictMargins(
        acceleration=found.acceleration,
        apart=None if found.unaided is None else Apart(found.unaided or None, ""),
        bearing=found.bearing,
        tilt=found.tilt,
        friction=found.friction,
        placement=found.placement,
        joints=found.joints,
        load_factor=found.load_factor,
    )
    if found.used_strength is not None:
        told = f"{100.0 * found.used_strength:.4g} % of the strength of its bricks"
        lines = [("needs", told)]
        if found.crushes_apart:
            lines.append(("apart", f"without friction between neighbours, {found.crushes_apart}"))
        return Display(found.name, [*lines, *notes], f"\u2713 {found.verdict}", True)
    texts = [*margin_texts(known)] or ["any disturbance"]
    lines = [*zip(["survives", *[""] * (len(texts) - 1)], texts, strict=True)]
    lines += [("weakest", weakest_text(found.weakest).removeprefix("weakest: "))] if found.weakest else []
    lines += [("limit", joints_text(found.joints))] if found.joints else []
    lines += [("beyond", found.yields)] if found.yields else []
    return Display(found.name, [*lines, *notes], f"\u2713 {found.verdict}", True)


@display_of.register
def _(found: Survival) -> Display:
    return lines_display([*survival_lines(found.name, found), *found.notes])
