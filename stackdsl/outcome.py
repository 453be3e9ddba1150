"""What a run came to: one outcome an expectation, one result a variant, one report a call. Renderers only read."""

from dataclasses import dataclass, field
from enum import StrEnum

from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.trace import Collapse, Cost


@dataclass(frozen=True, slots=True)
class Outcome:
    """One expectation, held against what was measured."""

    name: str  # the expectation's key, such as `stands`
    expected: str
    measured: str
    margin: float  # distance to the nearest threshold, in `unit`; negative when it failed
    unit: str
    passed: bool
    span: Span


class GoldenStatus(StrEnum):
    """How a variant's snapshot stands to its file."""

    SAME = "same"
    MISSING = "missing"
    DIFFERENT = "different"
    WRITTEN = "written"
    UNREADABLE = "unreadable"


@dataclass(frozen=True, slots=True)
class GoldenDifference:
    """One observation that left its tolerance."""

    subject: str  # brick name, or `structure`, or `event 3 (4 s)`
    quantity: str  # such as `x`, `state`, `share on L1.1`
    expected: str
    got: str
    tolerance: str


@dataclass(frozen=True, slots=True)
class GoldenResult:
    """The comparison of one snapshot with its file."""

    status: GoldenStatus
    file: str
    differences: tuple[GoldenDifference, ...] = ()
    note: str = ""  # such as a stamp that differs, or why the file cannot be read


class RunStatus(StrEnum):
    """How playing one variant ended."""

    DONE = "done"
    CRASHED = "crashed"
    TIMED_OUT = "timed out"


@dataclass(frozen=True, slots=True)
class VariantResult:
    """All that is known of one scenario on one system."""

    scenario: str
    variant: str  # such as `step=10mm,thesis`
    system: str
    file: str
    status: RunStatus
    verdict: str = ""  # `stands`, `collapses`; empty if it did not run
    collapse: Collapse | None = None
    drift: float = 0.0  # [m]
    cost: Cost | None = None
    outcomes: tuple[Outcome, ...] = ()  # expectations
    truths: tuple[Outcome, ...] = ()  # the same, against the answer known from outside; they inform and never fail
    golden: GoldenResult | None = None
    message: str = ""  # why it crashed or timed out

    @property
    def passed(self) -> bool:
        """Whether every expectation holds."""
        return self.status is RunStatus.DONE and all(outcome.passed for outcome in self.outcomes)


@dataclass(frozen=True, slots=True)
class Report:
    """The whole call, in the order of files, scenarios and systems."""

    results: tuple[VariantResult, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    obsolete: tuple[str, ...] = ()  # golden files that belong to no variant any more
    interrupted: bool = False
    wall_time: float = field(default=0.0, compare=False)  # [s]
