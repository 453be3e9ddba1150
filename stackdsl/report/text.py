"""The report of a check or a run as text."""

from collections.abc import Iterator, Sequence
from math import isfinite

from stability.model import BodyId
from stability.name_order import in_order, names_text
from stability.stabilizers.approach import IMMINENT, OVERLOADED
from stackdsl.report.warnings import (
    modified_text,
    passed_text,
    unclear_text,
    wrong_edges_text,
    wrong_friction_text,
)
from stackdsl.results import (
    KINDS,
    Change,
    ClaimOutcome,
    EarlyEndSummary,
    FailureCause,
    Report,
    Seen,
    VariantResult,
)
from stackdsl.trace import UNRELIABLE, BrickState, Event, EventKind, Trace
from stackdsl.wording import clock, energy_fault, how_many, level_text, shortened, significant, time_text, touching_text

# One expectation as one line: the expected and the measured value, and the margin to the threshold.
#
# Also the line for a run without expectations.


MARK_PASSED, MARK_FAILED = "\u2713", "\u2717"
TO_CLAIM = "add an expectation under `expect`, such as `- stands: all` or `- collapses: any`"


def outcome_text(outcome: ClaimOutcome) -> str:
    """Return the text of an outcome, without place and verdict."""
    return f"{outcome.name}: expected {outcome.expected}, measured {outcome.measured}{margin_text(outcome)}"


def margin_text(outcome: ClaimOutcome) -> str:
    """Return the margin of an outcome in parentheses; empty if there is none to tell."""
    if outcome.moved:
        return f" ({outcome.moved})" if outcome.passed else ""
    margin = margin_words(outcome)
    return f" ({'margin ' if outcome.margin >= 0.0 else ''}{margin})" if margin else ""


def margin_words(outcome: ClaimOutcome) -> str:
    """Return the margin of an outcome; empty if it has none, or if the measured text says all.

    A number of bricks is in the measured text. The shift or tilt that is left until a brick counts as fallen is no
    safety margin. Where no brick fell although one should, it is of no use.
    """
    of_fall = not outcome.passed and outcome.name == "collapses" and outcome.unit in ("mm", "deg")
    if not isfinite(outcome.margin) or outcome.unit == "bricks" or of_fall or outcome.moved:
        return ""
    number = significant(abs(outcome.margin))
    size = f"{number} {'level' if (number, outcome.unit) == ('1', 'levels') else outcome.unit}".rstrip()
    return size if outcome.margin >= 0.0 else f"misses by {size}"


def unchecked_text(result: VariantResult) -> str:
    """Return the text for a run without expectations, which says whether it fell."""
    if result.ensemble is not None:
        return f"no expectations; {result.ensemble.summary}"
    if result.collapse is None:
        return "no expectations"
    fell = result.collapse
    if fell.fallen:
        return f"{fell.text}; no expectations"
    where = level_text(fell.level, fell.step)
    return f"it fell at {where} ({fell.brick} at {fell.time:.3f} s), without expectations"


# One observation of two runs as one line.


NO_VALUE = "none"


def change_text(change: Change) -> str:
    """Return an observation, that of the other run, and the difference of numbers."""
    difference = change.difference
    by = f" ({'+' if difference > 0.0 else ''}{significant(difference)} {change.unit})" if difference else ""
    return f"{change.name}: {_seen(change.before, change.unit)} -> {_seen(change.after, change.unit)}{by}"


def decided_text(found: Sequence[Change]) -> str:
    """Return the values of each observation that nearby runs do not share, as in `6 or 14 fallen`."""
    values: dict[str, list[Seen]] = {}
    for change in found:
        values.setdefault(change.name, [change.before]).append(change.after)
    if fallen := values.get("fallen"):
        values.pop("drift of what stands", None)  # other bricks stand
        counts = dict.fromkeys(len(names) for names in fallen if isinstance(names, tuple))
        which = f" ({' or '.join(_seen(names, '') for names in dict.fromkeys(fallen))})" if len(counts) == 1 else ""
        told = [f"{' or '.join(map(str, sorted(counts)))} fallen{which}"]
    else:
        told = []
    for name, seen in values.items():
        if name != "fallen":
            told.append(f"{name}: {' or '.join(dict.fromkeys(_seen(each, KINDS[name].unit) for each in seen))}")
    return "; ".join(told)


def _seen(value: Seen, unit: str) -> str:
    match value:
        case float():
            return f"{significant(value)} {unit}"
        case tuple():
            names, more = shortened(value)
            return ", ".join((*names, *([f"{more} more"] if more else []))) or NO_VALUE
        case _:
            return value or NO_VALUE


# Events of a run as lines.


WORDS = {
    EventKind.FROZEN: "at rest",
    EventKind.WOKEN: "moves",
    EventKind.HIT: "hits",
    EventKind.COLLAPSED: "fallen",
    EventKind.OPENED: "opens",
}  # in place of their names
IN_FLIGHT = "in flight"  # of bricks that are thrown or dropped
SIMULATED = "simulated"  # of bricks that a hit or a load may move, and that do not move yet
MOST_HITS = 2  # hits told of one event


class EventLines:
    """The events of a run as lines; bricks that are placed and proven to stand at once share a line."""

    def __init__(self, all_names: bool = False) -> None:
        self._all_names = all_names
        self._placed: Event | None = None
        self._assembly: set[BodyId] = set()  # bricks that are placed and not removed

    def after(self, event: Event) -> Iterator[str]:
        """Yield the lines that are complete with one more event."""
        if event.kind is EventKind.PLACED:
            self._assembly |= set(event.bricks)
        elif event.kind is EventKind.REMOVED:
            self._assembly -= set(event.bricks)
        placed, self._placed = self._placed, None
        if placed is not None and _is_proof_of(event, placed):
            yield from self._placed_lines(placed, f", proven to stand: {event.reason}")
            return
        if placed is not None:
            yield from self._placed_lines(placed)
        if event.kind is EventKind.PLACED and not event.reason:
            self._placed = event
        else:
            yield from map(self._line, event.parts)

    def rest(self) -> Iterator[str]:
        """Yield the lines of the last event, if it was held back."""
        if self._placed is not None:
            yield from self._placed_lines(self._placed)
            self._placed = None

    def _placed_lines(self, placed: Event, proof: str = "") -> Iterator[str]:
        for part in placed.parts:
            yield self._line(part, "" if part.flying else proof)

    def _line(self, event: Event, more: str = "") -> str:
        bricks = event.bricks if event.kind is EventKind.PLACED else in_order(event.bricks)
        named = ", ".join(bricks) if self._all_names else names_text(bricks, least=1, among=self._assembly)
        reason = _few_hits(event.reason) if not self._all_names else event.reason
        if event.lying:
            reason = ""  # it does not stand
        imminent = event.kind is EventKind.WOKEN and IMMINENT in reason
        also = event.kind is EventKind.WOKEN and OVERLOADED in reason
        word = SIMULATED if imminent or also else IN_FLIGHT if event.flying else WORDS.get(event.kind, event.kind.value)
        # The reason of a proof does not begin with a name, even if a brick is called `load`.
        told_of = (EventKind.WOKEN, EventKind.HIT, EventKind.COLLAPSED)
        begins = event.kind is EventKind.OPENED or (
            event.kind in told_of and not (imminent or also) and reason.startswith(f"{named} ")
        )
        link = ", proven to stand: " if event.kind is EventKind.FROZEN else ": "
        named = f"also {named}" if also else named
        told = reason if begins else f"{named}{link}{reason}" if reason else named
        return f"{clock(event.time)}  {word:<9}  {told}{more}"


def _is_proof_of(event: Event, placed: Event) -> bool:
    same = event.time == placed.time and set(event.bricks) == set(placed.bricks) - set(placed.flying)
    return event.kind is EventKind.FROZEN and same


def _few_hits(reason: str) -> str:
    parts = reason.split("; ")
    hits = [part for part in parts if IMMINENT in part]
    if len(hits) < len(parts) or len(hits) <= MOST_HITS:
        return reason
    return f"{'; '.join(hits[:MOST_HITS])} and {how_many(len(hits) - MOST_HITS, 'more hit')}"


# Cause of a failed run, in a few lines.


def why_lines(why: FailureCause) -> Iterator[str]:
    """Yield one line for each known fact about the cause."""
    told = {"why": why.why, "after": why.before, "first": why.first, "see it": why.see}
    yield from (f"  {name:<8}  {text}" for name, text in told.items() if text)


# Text for a run that ended early.


def ending_text(early: EarlyEndSummary) -> str:
    """Return the time of the end and the actions that were left out."""
    left_out = early.actions
    undone = f"; {left_out} later action{'s' * (left_out > 1)} left out" if left_out else ""
    return f"ended at {early.time:.3f} s of {early.planned:.3f} s, as every claim is decided{undone}"


# The sums of a report as one line.


def closing_line(report: Report) -> str:
    """Return the sums in one line."""
    goldens = {"obsolete golden file": len(report.obsolete), "removed golden file": len(report.removed)}
    extras = {"mistake": len(report.diagnostics), **goldens}
    known = sum(result.remembered and not result.unchecked for result in report.results)
    conclusions = dict(report.conclusions)
    if known and (passed := conclusions.pop("passed")):
        conclusions = {f"passed ({known} remembered)": passed} | conclusions
    sums = [f"{count} {conclusion}" for conclusion, count in conclusions.items() if count]
    sums += [how_many(count, what) for what, count in extras.items() if count]
    sums += [f"{report.left} not run after a failure"] if report.left else []
    sums += ["interrupted"] if report.interrupted else []
    if not report.results and report.diagnostics:
        return f"{how_many(len(report.diagnostics), 'mistake')}, so nothing was run"
    ran = f"{how_many(report.scenarios, 'scenario')}, {how_many(len(report.results), 'case')}"
    return f"{ran}: {', '.join(sums) or 'no cases run'} in {report.wall_time:.1f} s"


# Result of one run as text: outcome and cost, then each claim with its measured value.


def run_text(trace: Trace, result: VariantResult, all_names: bool = False) -> str:
    """Return lines of text without a final newline; with `all_names` every brick is named."""
    return "\n".join(_lines(trace, result, all_names))


def _lines(trace: Trace, result: VariantResult, all_names: bool) -> Iterator[str]:
    fell = "" if trace.collapse is None else trace.collapse.text
    cost = (
        f"{time_text(trace.cost.simulated_time, 4)} simulated in {trace.cost.wall_time:.3g} s, {trace.cost.steps} steps"
    )
    came = f"{UNRELIABLE}: " * trace.unreliable + (fell or trace.verdict)
    yield f"{came}; {cost}" + (f"; a numerical collapse: {trace.numerical}" * bool(trace.numerical))
    yield from (f"warning: {odd}" for odd in result.warnings)
    if result.modified:
        yield modified_text(result.modified)
    fallen = [name for name, track in trace.tracks.items() if track.state is BrickState.FALLEN]
    if all_names and fallen:
        yield f"fallen: {', '.join(in_order(fallen))}"
    if trace.moving:
        moving = in_order(trace.moving)
        yield f"still moving at the end: {', '.join(moving) if all_names else names_text(moving, among=trace.tracks)}"
    again = in_order(name for name, track in trace.tracks.items() if track.stands_again)
    yield from (f"{name} counts as fallen: {trace.tracks[name].fell_by}, but stands at the end" for name in again)
    if result.early_end is not None:
        yield ending_text(result.early_end)
    if result.touching_within:
        yield f"statics: stable{touching_text(result.touching_within)}"
    if trace.energy_gained:
        yield energy_fault(trace.energy_gained)
    if trace.wrong_edges is not None:
        yield wrong_edges_text(trace.wrong_edges, trace.collapse)
    if trace.wrong_friction is not None:
        yield wrong_friction_text(trace.wrong_friction)
    if trace.passed_through is not None:
        yield passed_text(trace.passed_through)
    yield from claim_lines(result)


def claim_lines(result: VariantResult) -> Iterator[str]:
    """Yield each claim with its measured value, and the causes of failures."""
    if result.xfail is not None:
        yield f"{'unexpected pass' if result.passed else 'expected failure'} (xfail): {result.xfail}"
    for outcome in result.outcomes:
        mark = f"{MARK_PASSED} passed" if outcome.passed else f"{MARK_FAILED} failed"
        yield f"{mark}  {outcome_text(outcome)}  ({outcome.span})"
        if outcome.passed and outcome.unclear:
            yield f"note: {unclear_text(outcome)}"
    if result.why is not None:
        yield from why_lines(result.why)
    for truth in result.truths:
        yield f"truth {'agrees' if truth.passed else 'differs'}: {truth.span}: {outcome_text(truth)}"
