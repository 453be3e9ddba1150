"""Results: one outcome per claim, one result per variant, one report per call."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from math import degrees, isfinite
from typing import TypeAlias

from stability.engines.protocol import WrongFriction
from stability.geometry.placed_shape import top_W
from stability.model import BodyId
from stackdsl.diagnostics import Diagnostic, Span, Warned
from stackdsl.exits import ExitCode
from stackdsl.trace import (
    NO_PART,
    NUMERICAL_COLLAPSE,
    STAND,
    UNRELIABLE,
    BrickState,
    Collapse,
    Cost,
    EarlyEnd,
    Ensemble,
    Measure,
    Passed,
    Trace,
    WrongEdges,
)
from stackdsl.wording import MILLIMETRES

# Trace -> observations: what a person would note of a run, and what of it another run of the same scene changes.


Seen: TypeAlias = float | str | tuple[str, ...] | None  # None where there was nothing of the kind to see

PERCENT = 100.0
MOST_RELATIVE = 0.05  # what is large, such as how far debris flies, may change by this share of itself


@dataclass(frozen=True, slots=True)
class ObservationKind:
    """One kind of observation, and by how much it may change until it counts as moved."""

    unit: str = ""  # of numbers
    tolerance: float = 0.0  # in `unit`


KINDS: Mapping[str, ObservationKind] = {
    "verdict": ObservationKind(),
    "collapse level": ObservationKind("levels"),
    "collapse time": ObservationKind("s", 0.05),  # as in golden files
    "first to leave": ObservationKind(),
    "fallen": ObservationKind(),
    "drift": ObservationKind("mm", 0.1),  # of the whole structure, what fell included, as everywhere else
    "drift of what stands": ObservationKind("mm", 0.1),  # in the end; beside what fell, creep would hide
    "shift before": ObservationKind("mm", 0.1),  # the same when a brick was last set down before a collapse, or at all
    "largest tilt": ObservationKind("deg", 0.5),
    "height": ObservationKind("mm", 0.5),  # as in golden files
    "energy gain": ObservationKind("%", 0.1),
    "reach": ObservationKind("mm", 1.0),
    "bearing": ObservationKind("deg", 1.0),
}


@dataclass(frozen=True, slots=True)
class Change:
    """One observation of a run, and the same of the run that it is held against."""

    name: str  # a key of KINDS
    before: Seen
    after: Seen

    @property
    def unit(self) -> str:
        """Of both, where they are numbers."""
        return KINDS[self.name].unit

    @property
    def difference(self) -> float | None:
        """How much larger the second is; None unless both are numbers."""
        if isinstance(self.before, float) and isinstance(self.after, float):
            return turned_back(self.after - self.before) if self.name == "bearing" else self.after - self.before
        return None

    @property
    def moved(self) -> bool:
        """Whether they differ by more than the tolerance of their kind, or in anything that is no number."""
        if self.difference is None or not isinstance(self.before, float) or not isinstance(self.after, float):
            return self.before != self.after
        size = 0.0 if self.unit in ("levels", "deg") else max(abs(self.before), abs(self.after))
        return abs(self.difference) > max(KINDS[self.name].tolerance, MOST_RELATIVE * size)


def turned_back(angle: float) -> float:
    """An angle [deg] between -180 and 180."""
    return (angle + 180.0) % 360.0 - 180.0


def observations(trace: Trace) -> Mapping[str, Seen]:
    """All kinds, in the order of KINDS."""
    structure = [track for track in trace.tracks.values() if track.state not in NO_PART]
    placed = [track for track in structure if track.state is not BrickState.UNPLACED]
    standing = [track for track in placed if track.state in STAND]
    collapse, landing = trace.collapse, trace.landing
    seen: dict[str, Seen] = {
        "verdict": trace.reported_verdict,
        "collapse level": float(collapse.level) if collapse is not None else None,
        "collapse time": collapse.time if collapse is not None else None,
        "first to leave": collapse.brick if collapse is not None else None,
        "fallen": tuple(sorted(track.brick.id for track in placed if track.state is BrickState.FALLEN)),
        "drift": MILLIMETRES * trace.drift,
        "drift of what stands": MILLIMETRES * max((track.shift for track in standing), default=0.0),
        "shift before": MILLIMETRES * trace.shift_before,
        "largest tilt": degrees(max((track.tilt for track in placed), default=0.0)),
        "height": MILLIMETRES * max((top_W(track.brick.shape, track.final) for track in standing), default=0.0),
        "energy gain": _finite(PERCENT * trace.energy.gain) if trace.energy is not None else None,
        "reach": MILLIMETRES * landing.reach if landing is not None else None,
        "bearing": degrees(landing.bearing) if landing is not None else None,
    }
    return {name: seen[name] for name in KINDS}


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None


def changes(before: Mapping[str, Seen], after: Mapping[str, Seen]) -> tuple[Change, ...]:
    """Every kind that either run has seen, observation by observation."""
    pairs = ((name, before.get(name), after.get(name)) for name in KINDS)
    return tuple(Change(*pair) for pair in pairs if pair[1:] != (None, None))


# What a run came to: one outcome an expectation, one result a variant, one report a call. Renderers only read.


UNCHECKED = "unchecked"  # the conclusion of a run of which nothing is expected
REFERENCE_SYSTEM = "tuned"  # what speed-ups are told against: PyBullet with the settings that stack best


@dataclass(frozen=True, slots=True)
class ClaimOutcome:
    """One expectation, held against what was measured."""

    name: str  # the expectation's key, such as `stands`
    expected: str
    measured: str
    margin: float  # distance to the nearest threshold, in `unit`; negative when it failed
    unit: str
    passed: bool
    span: Span
    numbers: tuple[Measure, ...] = ()  # what of it is a number, with its limits


@dataclass(frozen=True, slots=True)
class Why:
    """What is known of why a run came out otherwise than expected; what is not known is empty or None."""

    cause: str = ""  # from the proof: what tips over what, or slides on what
    moving: tuple[BodyId, ...] = ()  # every brick of that proof
    bearing: float | None = None  # the side that it goes to, from +x towards +y [rad]
    overhang: float | None = None  # of what tips as one body: how far its weight lies beyond the edge [m]
    before: str = ""  # what was done just before, and where that is written
    first: str = ""  # what moved first
    see: str = ""  # the command for a shell that shows it


class GoldenStatus(StrEnum):
    """How a variant's snapshot stands to its file."""

    SAME = "same"
    MISSING = "missing"
    DIFFERENT = "different"
    WRITTEN = "written"
    NEW = "new"  # there was none, and it was written
    OTHER_ENGINE = "of another engine"  # made with it, and the same in what no engine decides
    NEWER = "newer"  # a newer version of stackdsl wrote it, so that it is neither read nor rewritten
    RENAMED = "renamed"  # there is none, and one that is nobody's says the same of a run that was called otherwise
    UNREADABLE = "unreadable"


GOLDEN_FAILURES = (
    GoldenStatus.MISSING,
    GoldenStatus.DIFFERENT,
    GoldenStatus.RENAMED,
    GoldenStatus.UNREADABLE,
    GoldenStatus.NEWER,
)


@dataclass(frozen=True, slots=True)
class GoldenDifference:
    """One observation that left its tolerance."""

    subject: str  # brick name, or `structure`, or `event 3 (4 s)`
    quantity: str  # such as `x`, `state`, `share on L1.1`
    expected: str
    got: str
    tolerance: str
    # Expected and got, in `unit`, where they are numbers.
    numbers: tuple[float | None, float | None] = field(default=(None, None), compare=False)
    unit: str = field(default="", compare=False)


@dataclass(frozen=True, slots=True)
class GoldenResult:
    """The comparison of one snapshot with its file."""

    status: GoldenStatus
    file: str
    differences: tuple[GoldenDifference, ...] = ()
    note: str = ""  # such as a stamp that differs, or why the file cannot be read
    digest: str = ""  # SHA-256 of the file that the snapshot was compared with; empty where it was with none
    renamed_from: str = ""  # the file that says the same of a run that was called otherwise
    offered: str = field(default="", compare=False, repr=False)  # the text that would be accepted; empty if it agrees


@dataclass(frozen=True, slots=True)
class Spared:
    """What was left out of a run that ended early, as all that is asked of it was known."""

    time: float  # of its end [s]
    planned: float  # until when it would have gone on [s]
    actions: int  # that would still have been done

    @classmethod
    def by(cls, early: EarlyEnd | None) -> "Spared | None":
        """What an early end spares; None where there was none."""
        return cls(early.time, early.planned, len(early.undone)) if early is not None else None


class RunStatus(StrEnum):
    """How playing one variant ended."""

    DONE = "done"
    SKIPPED = "skipped"  # what it needs is not installed
    BLOCKED = "blocked"  # an action could not be done, since something had moved in its way
    CRASHED = "crashed"
    TIMED_OUT = "timed out"
    NOT_RUN = "not run"  # the call was interrupted before its turn


@dataclass(frozen=True, slots=True)
class VariantResult:
    """All that is known of one scenario on one system."""

    scenario: str
    variant: str  # such as `step=10mm,thesis`
    system: str
    file: str
    status: RunStatus
    verdict: str = ""  # `stands`, `collapses`, `numerical-collapse`, `unreliable`; empty if it did not run
    numerical: str = ""  # why the collapse is the solver's and none of physics; empty where nothing says so
    wrong_edges: WrongEdges | None = None  # None where no contact was seen to have a wrong normal
    wrong_friction: WrongFriction | None = None  # the worst that an engine has had
    touching_within: float = 0.0  # [m] the verdict of statics counts on gaps up to this as contact; 0 if on none
    passed_through: Passed | None = None  # the first thrown brick that passed through another
    energy_gained: float = 0.0  # share of energy that the engine added by itself, where that is a fault
    collapse: Collapse | None = None
    ensemble: Ensemble | None = None  # what became of many samples; None of one run
    moving: tuple[BodyId, ...] = ()  # what was not at rest at the end
    early_end: Spared | None = None  # None where it went on for as long as it was to
    drift: float = 0.0  # [m]
    cost: Cost | None = None
    outcomes: tuple[ClaimOutcome, ...] = ()  # expectations
    why: Why | None = None  # None where every expectation holds
    truths: tuple[ClaimOutcome, ...] = ()  # the same, against the answer known from outside; they inform and never fail
    golden: GoldenResult | None = None
    engine: str = ""  # the package that took the steps; empty if none was taken
    modified: str = ""  # which constants of the scene are others than its author wrote; empty if none
    message: str = ""  # why it crashed, timed out or was skipped
    warnings: tuple[Warned, ...] = ()  # what is odd in the files that it comes from, and fails nothing
    mistake: Diagnostic | None = None  # what kept a run that was blocked from going on, and where in the file that is
    refinement: tuple[Change, ...] | None = None  # beside the refined run; None if that was not asked for
    parameters: tuple[tuple[str, str], ...] = ()  # the choice from each row of the matrix, as written
    remembered: bool = False  # from an earlier call, of the same program with the same files
    set_aside: bool = False  # whether it was skipped because its author says so
    xfail: str | None = None  # why its author knows it to fail; None if he does not
    strict: bool = False  # whether it is a failure that such a one passes
    must_claim: bool = False  # whether it is a failure that nothing is expected of it

    @property
    def unchecked(self) -> bool:
        """Whether it ran and nothing is expected of it, so that whatever came of it is as good as anything else."""
        return self.status is RunStatus.DONE and not self.outcomes

    @property
    def fell(self) -> bool:
        """Whether anything fell that had come to rest, in the run or in any of its samples."""
        return self.collapse is not None or (self.ensemble is not None and bool(self.ensemble.fell))

    @property
    def passed(self) -> bool:
        """Whether every expectation holds, and a run whose convergence is asked for did not fall for the solver."""
        if (self.refinement is not None and self.numerical) or (self.must_claim and self.unchecked):
            return False
        return self.status is RunStatus.DONE and all(outcome.passed for outcome in self.outcomes)

    @property
    def is_one_run(self) -> bool:
        """Whether there was one run, to its end."""
        return self.status is RunStatus.DONE and self.ensemble is None

    @property
    def unexpected(self) -> bool:
        """Whether it failed and nobody said that it would, or passed though it was said, strictly, to fail."""
        if self.must_claim and self.unchecked:
            return True
        if self.xfail is None or self.status is not RunStatus.DONE:
            return not self.passed
        return self.passed and self.strict

    @property
    def may_be_locked(self) -> bool:
        """Whether what came out may become a golden file unasked: all is as expected, or its author knows that not."""
        return self.passed or not self.unexpected

    @property
    def moved(self) -> tuple[Change, ...]:
        """The observations that refinement moves."""
        return tuple(change for change in self.refinement or () if change.moved)

    @property
    def name(self) -> str:
        """What people call it: the scenario, then the variant in brackets."""
        return f"{self.scenario}[{self.variant}]"

    @property
    def case(self) -> str:
        """The variant without its system, so that runs of one case on several systems find each other."""
        return self.variant.removesuffix(self.system).rstrip(",")

    @property
    def met(self) -> int:
        """How many expectations hold."""
        return sum(outcome.passed for outcome in self.outcomes)

    @property
    def truth_agrees(self) -> bool | None:
        """Whether all answers known from outside are met; None if there are none."""
        return all(truth.passed for truth in self.truths) if self.truths else None

    @property
    def golden_failed(self) -> bool:
        """Whether the snapshot and its file do not agree."""
        return self.golden is not None and self.golden.status in GOLDEN_FAILURES

    @property
    def wall_per_simulated(self) -> float | None:
        """Wall seconds for one second of the scenario's clock; None if it did not finish or took no time."""
        if self.status is not RunStatus.DONE or self.cost is None:
            return None
        cost = self.cost
        return cost.wall_time / cost.simulated_time if min(cost.wall_time, cost.simulated_time) > 0.0 else None

    @property
    def conclusion(self) -> str:
        """The one word or two that a closing count files it under."""
        if self.status is not RunStatus.DONE:
            return self.status.value
        if self.xfail is not None and not self.golden_failed:
            return "xpassed" if self.passed else "xfailed"
        only_solver = self.refinement is not None and bool(self.numerical)
        if not self.passed and self.xfail is None and (only_solver or not self.unchecked):
            return NUMERICAL_COLLAPSE if self.numerical else UNRELIABLE if self.verdict == UNRELIABLE else "failed"
        told = self.golden is not None and (self.golden_failed or self.golden.status is GoldenStatus.OTHER_ENGINE)
        if self.unchecked and (self.must_claim or not told):
            return UNCHECKED
        return f"golden {self.golden.status.value}" if self.golden is not None and told else "passed"


@dataclass(frozen=True, slots=True)
class Report:
    """The whole call, in the order of files, scenarios and systems."""

    results: tuple[VariantResult, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    obsolete: tuple[str, ...] = ()  # golden files that belong to no variant any more
    removed: tuple[str, ...] = ()  # obsolete golden files that this call removed
    interrupted: bool = False
    left: int = 0  # cases that were not played, since one failed and that was to be enough
    accept: str = ""  # the command that accepts all that differs from its golden file, and removes what is obsolete
    wall_time: float = field(default=0.0, compare=False)  # [s]

    @property
    def scenarios(self) -> int:
        """How many scenarios have a result."""
        return len({(result.file, result.scenario) for result in self.results})

    @property
    def conclusions(self) -> Mapping[str, int]:
        """How many variants ended which way: `passed` first, the rest by name."""
        counts = Counter(result.conclusion for result in self.results)
        return {"passed": counts.pop("passed", 0)} | dict(sorted(counts.items()))

    def speed_up(self, result: VariantResult) -> float | None:
        """How many times less wall time a simulated second took than for the same case on REFERENCE_SYSTEM.

        Per simulated second, since a run that collapses early also stops early.
        """
        own, reference = result.wall_per_simulated, self._reference_cost(result)
        return reference / own if own is not None and reference is not None else None

    def _reference_cost(self, result: VariantResult) -> float | None:
        wanted = (result.file, result.scenario, result.case, REFERENCE_SYSTEM)
        return next(
            (
                other.wall_per_simulated
                for other in self.results
                if (other.file, other.scenario, other.case, other.system) == wanted
            ),
            None,
        )


def exit_code(report: Report) -> int:
    """The process exit code of a report; of several reasons the one that makes the others least trustworthy."""
    if report.interrupted:
        return ExitCode.INTERRUPTED
    if report.diagnostics or any(result.status is RunStatus.BLOCKED for result in report.results):
        return ExitCode.INVALID
    tried = [result for result in report.results if result.status is not RunStatus.SKIPPED]
    if any(result.status is not RunStatus.DONE for result in tried):
        return ExitCode.CRASHED
    if not tried and not any(result.set_aside for result in report.results):
        return ExitCode.USAGE
    if any(result.unexpected for result in tried):
        return ExitCode.FAILED
    if report.obsolete or any(result.golden_failed for result in report.results):
        return ExitCode.GOLDEN
    return ExitCode.OK
