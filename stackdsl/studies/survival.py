"""The acceleration and tilt that the structure of a case survives, by bearing, and the part that fails first."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from stability.analysis.weakest import Weakest
from stability.name_order import names_text
from stability.notebook import Printed, display_of
from stability.statics.fall_description import fall_side
from stackdsl.checking.cases import Case
from stackdsl.judging.proofs import ALL, NO_MARGIN, RIGID, Proofs, Survival, margins_of_assembly, proofs_of, survival_of
from stackdsl.studies.limit_search import SearchError
from stackdsl.trace import USED_STRENGTH, VerdictMargins
from stackdsl.wording import side_text

if TYPE_CHECKING:
    from stability.problem import PlacementLimit


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
    if proofs.assembly.strengths:
        raise SearchError(RIGID)
    if unproven := _unproven(proofs):
        if not proofs.assembly.bricks:
            raise SearchError(unproven)
        judged = proofs.verdict.stability.upper()
        raise SearchError(f"{judged}: {unproven}; {NO_MARGIN}")
    survival = survival_of(proofs.assembly, bearings, accuracy, on_bearing)
    if survival is None:
        raise SearchError("unknown: no contact forces were found that are far enough inside the friction cones")
    return replace(survival, name=name, notes=_notes(case, proofs))


@dataclass(frozen=True, slots=True, repr=False)
class CaseMargins(Printed):
    """The disturbances that a structure survives, in SI units; each is None if it is not proven to stand."""

    name: str  # of the case
    verdict: str  # `stable`, `unstable` or `undecided`
    why: str  # why it is not proven to stand; empty if it is
    acceleration: float | None  # horizontal, in the worst direction [g]
    unaided: float | None  # the same without friction between side faces; None where equal, 0 if it falls without it
    bearing: float | None  # of that direction, from +x towards +y [rad]
    tilt: float | None  # of the whole scene, in the worst direction [rad]
    friction: float | None  # least coefficient of the roughest contact, with all others in proportion
    placement: float | None  # error in the position of every brick [m]; inf if no brick lies on another one
    weakest: Weakest | None = None  # what gives way first above `acceleration`, and on a tilt above `tilt`
    joints: tuple["PlacementLimit", ...] = ()  # the contacts that limit `placement` equally
    notes: tuple[str, ...] = ()  # parts of the case that are not judged
    load_factor: float | None = None  # multiple of its own weight that it bears; only for bricks with joints
    yields: str = ""  # what gives way above that load factor
    used_strength: float | None = None  # share of their strength that the bricks need; only where some have a strength
    crushes_apart: str = ""  # what crushes without friction between neighbours

    def __repr__(self) -> str:
        """Return the text of `print` on one line, which pytest shows where an assertion fails."""
        told = display_of(self)
        return f"<{told.word} {told.title}: {'; '.join(text for _, text in told.lines)}>"


def margins_in(case: Case, name: str) -> CaseMargins:
    """Return the margins of a case called `name`, as `stackdsl explain` reports them."""
    proofs = proofs_of(case.timeline)
    unproven, crushes = _unproven(proofs), bool(proofs.assembly.strengths)
    wanted = {USED_STRENGTH} if crushes else ALL
    found = VerdictMargins() if unproven else margins_of_assembly(proofs.assembly, wanted)
    unaided = None if found.apart is None or crushes else found.apart.acceleration or 0.0
    crushing = found.apart.gives_way if crushes and found.apart is not None else ""
    numbers = (found.acceleration, unaided, found.bearing, found.tilt, found.friction, found.placement)
    notes = () if unproven else _notes(case, proofs)
    verdict, beyond = proofs.verdict.stability.value, (found.load_factor, found.yields)
    strength = found.used_strength, crushing
    return CaseMargins(name, verdict, unproven, *numbers, found.weakest, found.joints, notes, *beyond, *strength)


def _unproven(proofs: Proofs) -> str:
    """Return why a structure is not proven to stand, with the direction of a fall; empty if it is."""
    if not proofs.assembly.bricks:
        return "no brick is set down at rest, so statics has nothing to judge"
    verdict = proofs.verdict
    return ", ".join(filter(None, [verdict.reason, side_text(fall_side(verdict, proofs.assembly.bricks))]))


def _notes(case: Case, proofs: Proofs) -> tuple[str, ...]:
    """Return the parts of a case that are not judged."""
    standing = len(proofs.assembly.bricks)
    pulled = [brick for brick in case.timeline.pulled_out if brick not in proofs.assembly.bricks]
    count = sum(not placement.hits for placement in case.timeline.placements) - len(pulled)
    notes = []
    if standing < count:
        notes.append(f"computed for {standing} of {count} bricks; the later ones depend on the engine")
    if pulled:
        notes.append(f"judged without {names_text(pulled)}, which an impact pulls out")
    return tuple(notes)
