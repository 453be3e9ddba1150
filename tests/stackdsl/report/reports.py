"""Reports for tests, as a check would hand them over."""

from dataclasses import replace

from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.results import (
    ClaimOutcome,
    GoldenDifference,
    GoldenResult,
    GoldenStatus,
    Report,
    RunStatus,
    VariantResult,
)
from stackdsl.trace import Collapse, Cost, Updates

SPAN = Span("scenarios/slant.yaml", 14, 5, 14)
HELD = ClaimOutcome("stands", "3 levels", "3 levels", margin=0.0, unit="levels", passed=True, span=SPAN)
MISSED = ClaimOutcome("collapses", "level 9 ± 1", "level 11", margin=-1.0, unit="levels", passed=False, span=SPAN)
MISTAKE = Diagnostic(
    "SD204", replace(SPAN, excerpt="    brick: tpo"), "unknown brick 'tpo'", hint="did you mean 'top'?"
)
GOLDEN = GoldenResult(GoldenStatus.SAME, "golden/slant/thesis.json")
MOVED = GoldenDifference("L9.1", "x", "48.00 mm", "47.10 mm", "± 0.5 mm")
PASSED = VariantResult(
    scenario="slant",
    variant="step=11mm,thesis",
    system="thesis",
    file="scenarios/slant.yaml",
    status=RunStatus.DONE,
    verdict="collapses",
    collapse=Collapse(time=8.25, level=9, brick="L9.1", gave_way="L1.1"),
    drift=0.123456,
    cost=Cost(
        wall_time=2.0,
        simulated_time=10.0,
        steps=9600,
        judgements=120,
        proofs={"load core": 8},
        updates=Updates(0.002, 0.25),
    ),
    outcomes=(HELD, HELD),
    golden=GOLDEN,
)
TUNED = replace(
    PASSED,
    variant="step=11mm,tuned",
    system="tuned",
    cost=Cost(wall_time=3.0, simulated_time=5.0, steps=1, judgements=0),
)
FAILED = replace(PASSED, outcomes=(HELD, MISSED))
UNRELIABLE = replace(FAILED, verdict="unreliable", energy_gained=0.046)
CRASHED = replace(
    PASSED, status=RunStatus.CRASHED, verdict="", collapse=None, cost=None, outcomes=(), golden=None,
    message="the worker was killed by SIGSEGV",
)  # fmt: skip
LATE = replace(CRASHED, status=RunStatus.TIMED_OUT, message="took longer than 60 s")
NOT_RUN = replace(CRASHED, status=RunStatus.NOT_RUN, message="")


def with_golden(status: GoldenStatus, note: str = "", *differences: GoldenDifference) -> VariantResult:
    return replace(PASSED, golden=replace(GOLDEN, status=status, note=note, differences=differences))


def report(
    *results: VariantResult,
    diagnostics: tuple[Diagnostic, ...] = (),
    obsolete: tuple[str, ...] = (),
    removed: tuple[str, ...] = (),
    interrupted: bool = False,
) -> Report:
    return Report(results, diagnostics, obsolete, removed, interrupted, wall_time=12.34)


FULL = report(
    replace(PASSED, truths=(MISSED,)),
    TUNED,
    FAILED,
    CRASHED,
    with_golden(GoldenStatus.DIFFERENT, "made with python 3.10 (now 3.11)", MOVED),
    diagnostics=(MISTAKE,),
    obsolete=("golden/gone/x.json",),
    removed=("golden/old/x.json",),
    interrupted=True,
)
