"""What came of a case of many samples: its claims judged, its counts held against its golden file."""

from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

from stackdsl.checking.ensembles import drawn_alone
from stackdsl.checking.gathering import STDIN_SHOWN, Case
from stackdsl.checking.results import Goldens, checked, held_against
from stackdsl.ensemble import Ensemble, OnDrawn, untold
from stackdsl.judging.judge import judge_shares
from stackdsl.outcome import RunStatus, VariantResult
from stackdsl.snapshots.samples import snapshot_of_samples
from stackdsl.snapshots.stamp import current_stamp
from stackdsl.supervising.executors import run_on
from stackdsl.supervising.processes import run_supervised
from stackdsl.systems.known_systems import system_named
from stackdsl.systems.systems import Method
from stackdsl.trace import Cost

TIME_LIMIT = 600.0  # [s] of wall time a chunk of samples
NO_GOLDENS = Goldens(None)


def drawn_result(
    case: Case,
    workers: int,
    goldens: Goldens = NO_GOLDENS,
    executor: Executor | None = None,
    on_drawn: OnDrawn = untold,
) -> VariantResult:
    """Draw the samples of a case, as many as decide: here, or on an executor that does so many calls at a time.

    Raises KeyboardInterrupt where somebody interrupts that.
    """
    run = partial(run_on, executor) if executor else run_supervised
    drawing = drawn_alone(case, workers, TIME_LIMIT, run, on_drawn)
    if drawing is None:
        raise KeyboardInterrupt
    if drawing.failed is not None:
        return checked(case, drawing.failed, NO_GOLDENS)
    return checked_samples(case, drawing.ensemble(), goldens)


def checked_samples(case: Case, ensemble: Ensemble, goldens: Goldens, must_claim: bool = False) -> VariantResult:
    """The result of a case of many samples: expectations, truths, and the comparison with its golden file.

    With `must_claim` it is a failure if nothing is expected of the case.
    """
    result = replace(judged_samples(case, ensemble), must_claim=must_claim)
    proven = system_named(case.system).method is Method.PROVEN  # what an engine makes of samples is its own affair
    if goldens.folder is None or not proven or case.file == STDIN_SHOWN:
        return result
    snapshot = snapshot_of_samples(ensemble, case.timeline.world, case.identity, current_stamp("", 0))
    return replace(result, golden=held_against(snapshot, goldens, case.source.file, result))


def judged_samples(case: Case, ensemble: Ensemble) -> VariantResult:
    """The result of a case of many samples, without its golden file."""
    outcomes, truths, _ = judge_shares(ensemble, case.scenario, case.variant, case.source, case.system)
    xfail = case.scenario.xfail
    marked = xfail is not None and xfail.is_of(case.system)
    result = VariantResult(case.identity.scenario, case.identity.variant, case.system, case.file, RunStatus.DONE)
    return replace(
        result,
        xfail=xfail.reason if xfail is not None and marked else None,
        strict=xfail is not None and marked and xfail.strict,
        verdict=ensemble.summary,
        ensemble=ensemble,
        warnings=case.source.warnings,
        cost=Cost(wall_time=ensemble.cpu_time, simulated_time=0.0, steps=0, judgements=ensemble.drawn),
        outcomes=outcomes,
        truths=truths,
        parameters=case.parameters,
    )
