"""How one run ended, as text: what came of it and what it took, then every claim beside what was measured."""

from collections.abc import Iterator

from stability.name_order import in_order
from stackdsl.outcome import VariantResult
from stackdsl.report.edge_text import wrong_edges_text
from stackdsl.report.ending_text import ending_text
from stackdsl.report.friction_text import wrong_friction_text
from stackdsl.report.modified_text import modified_text
from stackdsl.report.outcome_text import outcome_text
from stackdsl.report.passing_text import passed_text
from stackdsl.report.why_text import why_lines
from stackdsl.trace import UNRELIABLE, BrickState, Collapse, Trace
from stackdsl.wording import broke_text, energy_fault, level_text, names_text, touching_text


def run_text(trace: Trace, result: VariantResult, all_names: bool = False) -> str:
    """Several lines of text without a newline at the end; with `all_names` every brick is named."""
    return "\n".join(_lines(trace, result, all_names))


def _lines(trace: Trace, result: VariantResult, all_names: bool) -> Iterator[str]:
    fell = "" if trace.collapse is None else _collapse(trace.collapse)
    cost = f"{trace.cost.simulated_time:g} s played in {trace.cost.wall_time:.3f} s, {trace.cost.steps} steps"
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
        yield f"still moving at the end: {', '.join(moving) if all_names else names_text(moving)}"
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


def _collapse(collapse: Collapse) -> str:
    at = f"collapses at {level_text(collapse.level, collapse.step)} after {collapse.time:.3f} s"
    return at + broke_text(collapse.broke, collapse.gave_way)


def claim_lines(result: VariantResult) -> Iterator[str]:
    """Every claim beside what was measured, and why some failed."""
    if result.xfail is not None:
        yield f"{'passed, though it was' if result.passed else 'failed, as was'} said to fail: {result.xfail}"
    for outcome in result.outcomes:
        yield f"{'passed' if outcome.passed else 'failed'}: {outcome.span}: {outcome_text(outcome)}"
    if result.why is not None:
        yield from why_lines(result.why)
    for truth in result.truths:
        yield f"truth {'agrees' if truth.passed else 'differs'}: {truth.span}: {outcome_text(truth)}"
