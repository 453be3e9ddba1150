"""The acceleration and tilt that the structure of a case survives, by bearing, and the part that fails first."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from stability.name_order import names_text
from stackdsl.checking.cases import Case
from stackdsl.judging.proofs import Survival, proofs_of, survival_of
from stackdsl.studies.find_limit import SearchError

BEARINGS: Final = 72
FEWEST_BEARINGS, MOST_BEARINGS = 4, 3600
ACCURACY: Final = 0.01  # relative
FINEST, COARSEST = 1e-6, 0.5


def survive_in(
    case: Case, name: str, bearings: int, accuracy: float, on_bearing: Callable[[int], None] = lambda _: None
) -> Survival:
    """Return the accelerations that a case called `name` survives. Raises SearchError, which says why none is known.

    `on_bearing` is called with the number of bearings that are finished.
    """
    proofs = proofs_of(case.timeline)
    verdict, standing = proofs.verdict, len(proofs.assembly.bricks)
    pulled = [brick for brick in case.timeline.pulled_out if brick not in proofs.assembly.bricks]
    count = sum(not placement.hits for placement in case.timeline.placements) - len(pulled)
    if standing == 0:
        raise SearchError("no brick is set down at rest, so statics has nothing to judge")
    if verdict.reason:
        raise SearchError(f"{verdict.stability.upper()}: {verdict.reason}; only a stable structure has margins")
    survival = survival_of(proofs.assembly, bearings, accuracy, on_bearing)
    if survival is None:
        raise SearchError("unknown: no contact forces were found that are far enough inside the friction cones")
    notes = []
    if standing < count:
        notes.append(f"computed for {standing} of {count} bricks; the later ones depend on the engine")
    if pulled:
        notes.append(f"judged without {names_text(pulled)}, which an impact pulls out")
    return replace(survival, name=name, notes=tuple(notes))
