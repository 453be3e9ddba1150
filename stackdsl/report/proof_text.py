"""What statics says of a build, as text: proofs of placements, what they would survive, and what would mend a fall."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import degrees, inf

from stability.model import BodyId
from stability.name_order import in_order
from stability.statics.facts import Stability
from stability.statics.solvers.fall_side import fall_side
from stackdsl.judging.knobs import Knobs
from stackdsl.judging.margins import ALL, MOST_FOR_PROGRAMS, margins_of_assembly
from stackdsl.judging.proofs import Judged, Proofs
from stackdsl.judging.remedies import remedies_of
from stackdsl.proof_margins import Margins
from stackdsl.report.remedy_text import remedy_lines
from stackdsl.report.side_text import side_text
from stackdsl.report.weakest_text import weakest_text
from stackdsl.timeline import Timeline
from stackdsl.wording import mm, touching_text

MICROSECONDS = 1e6
TOLD = (*ALL, "guaranteed", "squeezed")  # the margins that are told of what stands


@dataclass(frozen=True, slots=True)
class Extent:
    """How much is worked out and told."""

    margins: bool | None = None  # what proofs would survive; None: of few bricks
    remedies: bool | None = None  # what would mend a fall; None: of few bricks
    times: bool = False  # what each proof cost, which differs from run to run


def stages_told(proofs: Proofs, times: bool) -> Mapping[BodyId, str]:
    """What is said of each brick that was judged: its proof; with `times`, and the last of a group, what it cost."""
    told = {}
    for judged in proofs.judged:
        for brick in judged.bricks:
            cost = _cost(judged) if times and brick == judged.bricks[-1] else ""
            told[brick] = f"  {_answer(judged, brick)}{cost}"
    return told


def _answer(judged: Judged, brick: BodyId) -> str:
    if brick in judged.verdict.moving:
        answer = "falls" if judged.verdict.stability is Stability.UNSTABLE else "in doubt"
        return f"{answer}: {judged.verdict.stage}" if judged.verdict.stage is not None else answer
    stage = judged.stages[brick]
    return f"{stage}" if stage is not None else "not proven"


def _cost(judged: Judged) -> str:
    together = f" for {len(judged.bricks)} bricks" if len(judged.bricks) > 1 else ""
    return f", {MICROSECONDS * judged.verdict.seconds:.0f} us{together}"


def proven_lines(  # noqa: PLR0913, PLR0917 -- all that is told
    proofs: Proofs, timeline: Timeline, count: int, extent: Extent, knobs: Knobs, margins: Margins | None = None
) -> Iterator[str]:
    """What became of all that was judged, of `count` bricks in all; `margins` are those that are `TOLD`, if known."""
    verdict, judged = proofs.verdict, sum(len(judged.bricks) for judged in proofs.judged)
    if verdict.stability is not Stability.STABLE:
        yield f"  statics: {verdict.stability.upper()}: {verdict.reason}; the engine shows what comes of it"
        yield from _fall(proofs, timeline, extent, knobs)
    elif judged < count:
        yield f"  statics: {judged} of {count} bricks proven to stand; the engine shows what comes of the others"
    else:
        seconds = sum(judged.verdict.seconds for judged in proofs.judged)
        cost = f", in {1000.0 * seconds:.3g} ms" if extent.times else ""
        within = verdict.touching_within
        yield f"  statics: every placement proven to stand{touching_text(within)}{cost}"
        if within > 0.0:
            yield f"    this counts on gaps of up to {mm(within)} as contact; with `touching: exactly` it is not proven"
        yield from _margins(proofs, extent, margins)


def _fall(proofs: Proofs, timeline: Timeline, extent: Extent, knobs: Knobs) -> Iterator[str]:
    """Everything that moves, which way, and what would mend it."""
    verdict, bricks = proofs.verdict, proofs.assembly.bricks
    in_doubt = verdict.stability is Stability.UNDECIDED
    yield f"    {'in doubt' if in_doubt else 'moves'}: {', '.join(in_order(verdict.moving))}"
    if side := side_text(fall_side(verdict, bricks)):
        yield f"    it goes {side}"
    if in_doubt or extent.remedies is False:
        return
    if extent.remedies is None and len(bricks) > MOST_FOR_PROGRAMS:
        yield f"    what would mend more than {MOST_FOR_PROGRAMS} bricks takes its time; ask for it with --remedies"
        return
    yield "    what would mend it, each tried:"
    yield from (f"      {line}" for line in remedy_lines(remedies_of(knobs, timeline, proofs)))


def _margins(proofs: Proofs, extent: Extent, margins: Margins | None) -> Iterator[str]:
    count = len(proofs.assembly.bricks)
    if extent.margins is False:
        return
    if extent.margins is None and count > MOST_FOR_PROGRAMS:
        yield f"    margins of more than {MOST_FOR_PROGRAMS} bricks take their time; ask for them with --margins"
        return
    margins = margins or margins_of_assembly(proofs.assembly, TOLD)
    yield "    it would survive " + "; ".join(_margin_texts(margins))
    if margins.squeezed:
        yield "    this counts on contacts that may be squeezed together, as hard as it takes, or may not be"
    if margins.weakest is not None:
        yield f"    {weakest_text(margins.weakest)}"
    if margins.joint is not None:
        lower, upper = margins.joint
        yield f"    least margin of placement: {upper} on {lower}"
    if margins.guaranteed is not None:
        yield f"    rest is {_certainty(margins)}"


def _certainty(margins: Margins) -> str:
    """Whether rest is all that can happen, and why."""
    why = margins.certainty or "forces along normals alone balance every brick"
    return f"{'guaranteed' if margins.guaranteed else 'possible'}: {why}"


def _margin_texts(margins: Margins) -> Iterator[str]:
    if margins.acceleration is not None:
        bearing = f" towards {round(degrees(margins.bearing)) % 360} deg" if margins.bearing is not None else ""
        yield f"{margins.acceleration:.4g} g sideways, worst{bearing}"
    if margins.tilt is not None:
        yield f"a tilt of {degrees(margins.tilt):.4g} deg"
    if margins.friction is not None:
        yield f"friction down to {margins.friction:.4g}"
    if margins.placement == inf:  # all lies on the ground, and nothing on another brick
        yield "every brick however far beside its place"
    elif margins.placement is not None:
        yield f"every brick {round(1000.0 * margins.placement, 6):.4g} mm beside its place"
