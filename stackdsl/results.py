"""Results of a call: one outcome per claim, one result per variant, one report per call."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from math import degrees, isfinite
from typing import TYPE_CHECKING, NoReturn, TypeAlias

from stability.engines.protocol import WrongFriction
from stability.geometry.placed_shape import top_W
from stability.model import BodyId
from stability.name_order import names_text
from stability.notebook import Displayed
from stability.statics.fall_description import FallSide
from stackdsl.diagnostics import Diagnostic, ScenarioWarning, Span, unknown_attribute
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
    PassedThrough,
    Trace,
    WrongEdges,
)
from stackdsl.wording import MILLIMETRES, and_text, how_many, side_text

# Observations of a run, and their changes in another run of the same scene.


Seen: TypeAlias = float | str | tuple[str, ...] | None  # None if the run has no such observation

PERCENT = 100.0
MOST_RELATIVE = 0.05  # relative tolerance, for large values such as the reach of debris


@dataclass(frozen=True, slots=True)
class ObservationKind:
    """A kind of observation, and the tolerance on its changes."""

    unit: str = ""  # of numbers
    tolerance: float = 0.0  # in `unit`


KINDS: Mapping[str, ObservationKind] = {
    "verdict": ObservationKind(),
    "collapse level": ObservationKind("levels"),
    "collapse time": ObservationKind("s", 0.05),  # as in golden files
    "first to leave": ObservationKind(),
    "fallen": ObservationKind(),
    "drift": ObservationKind("mm", 0.1),  # of the whole structure, with fallen bricks, as everywhere else
    "drift of what stands": ObservationKind("mm", 0.1),  # shows creep, which the drift of fallen bricks would hide
    "shift before": ObservationKind("mm", 0.1),  # drift at the last placement, or the last before a collapse
    "largest tilt": ObservationKind("deg", 0.5),
    "height": ObservationKind("mm", 0.5),  # as in golden files
    "energy gain": ObservationKind("%", 0.1),
    "reach": ObservationKind("mm", 1.0),
    "bearing": ObservationKind("deg", 1.0),
}


@dataclass(frozen=True, slots=True)
class Change:
    """One observation in two runs."""

    name: str  # a key of KINDS
    before: Seen
    after: Seen

    @property
    def unit(self) -> str:
        """Return the unit of both values, if they are numbers."""
        return KINDS[self.name].unit

    @property
    def difference(self) -> float | None:
        """Return the second value minus the first; None unless both are numbers."""
        if isinstance(self.before, float) and isinstance(self.after, float):
            return turned_back(self.after - self.before) if self.name == "bearing" else self.after - self.before
        return None

    @property
    def moved(self) -> bool:
        """Return whether numbers differ by more than the tolerance of their kind, or other values differ at all."""
        if self.difference is None or not isinstance(self.before, float) or not isinstance(self.after, float):
            return self.before != self.after
        size = 0.0 if self.unit in ("levels", "deg") else max(abs(self.before), abs(self.after))
        return abs(self.difference) > max(KINDS[self.name].tolerance, MOST_RELATIVE * size)


def turned_back(angle: float) -> float:
    """Wrap an angle [deg] to the range from -180 to 180."""
    return (angle + 180.0) % 360.0 - 180.0


def observations(trace: Trace) -> Mapping[str, Seen]:
    """Return all observations of a run, in the order of KINDS."""
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
    """Return a change for each kind of observation that at least one of two runs has."""
    pairs = ((name, before.get(name), after.get(name)) for name in KINDS)
    return tuple(Change(*pair) for pair in pairs if pair[1:] != (None, None))


# Outcomes of claims, results of variants, and the report of a call. Renderers only read them.


UNCHECKED = "unchecked"  # conclusion of a run without expectations
REFERENCE_SYSTEM = "tuned"  # reference of speed-ups: PyBullet with the best settings for stacks


@dataclass(frozen=True, slots=True, repr=False)
class ClaimOutcome(Displayed):
    """The comparison of a claim with the measured value."""

    name: str  # the expectation's key, such as `stands`
    expected: str
    measured: str
    margin: float  # distance of the measured value to the nearest threshold, in `unit`; negative when it failed
    unit: str  # of the margin, as in reports: mm, deg, %, s; `levels` and `bricks` for counts
    passed: bool
    span: Span
    numbers: tuple[Measure, ...] = ()  # measured numbers, with their limits
    moved: str = ""  # largest shift or tilt beside its limit, if `margin` is the rest of it and not a safety margin
    why: str = field(default="", compare=False)  # cause of a failure; a report of a run has it once for all claims
    unclear: int = field(default=0, compare=False)  # bricks whose fate decides the claim, and may change by chance

    @property
    def value(self) -> float | None:
        """The measured number in the unit of reports, such as mm; None unless the claim measures exactly one."""
        return self.numbers[0].value if len(self.numbers) == 1 else None

    def __bool__(self) -> bool:
        """Return whether the claim holds, so that `assert run.judge(claim)` fails if it does not."""
        return self.passed

    def __repr__(self) -> str:
        """Return expected and measured value and the cause, which pytest shows where an assertion fails."""
        word, why = "passed" if self.passed else "failed", f", why: {self.why}" * bool(self.why)
        return f"<{word}: {self.name}: expected {self.expected}, measured {self.measured}{why}>"


@dataclass(frozen=True, slots=True)
class FailureCause(Displayed):
    """Explanation of an unexpected outcome; unknown parts are empty or None."""

    cause: str = ""  # from the proof: bricks that tip or slide, and on which bodies
    moving: tuple[BodyId, ...] = ()  # all moving bricks of the proof
    bearing: float | None = None  # direction of the motion, from +x towards +y [rad]
    overhang: float | None = None  # distance of the centre of mass beyond the edge, of bricks tipping as one body [m]
    before: str = ""  # the last action before, with its place in the file
    first: str = ""  # the first brick that moved
    see: str = ""  # the shell command that shows it

    @property
    def why(self) -> str:
        """The cause with the direction of the fall, as in reports; empty if unknown."""
        return ", ".join(filter(None, [self.cause, side_text(FallSide(self.bearing, self.overhang))]))

    def __str__(self) -> str:
        """Return `why`."""
        return self.why

    if not TYPE_CHECKING:  # with `__getattr__`, type checkers would accept any name

        def __getattr__(self, name: str) -> NoReturn:
            """Raise AttributeError, which names the attribute that is meant."""
            raise unknown_attribute(self, name, {"reason": "write `why`", "text": "write `why`"})


class GoldenStatus(StrEnum):
    """Result of comparing a snapshot with its golden file."""

    SAME = "same"
    MISSING = "missing"
    DIFFERENT = "different"
    WRITTEN = "written"
    NEW = "new"  # the file was missing and has been written
    OTHER_ENGINE = "of another engine"  # made by another engine, and equal in all that engines do not decide
    NEWER = "newer"  # written by a newer version of stackdsl, so it is neither read nor rewritten
    RENAMED = "renamed"  # missing, but an obsolete file of another name has the same content
    UNREADABLE = "unreadable"


GOLDEN_FAILURES = (
    GoldenStatus.MISSING,
    GoldenStatus.DIFFERENT,
    GoldenStatus.RENAMED,
    GoldenStatus.UNREADABLE,
    GoldenStatus.NEWER,
)


FEW = 3  # differences in the text of a comparison


@dataclass(frozen=True, slots=True)
class GoldenDifference:
    """One observation beyond its tolerance."""

    subject: str  # brick name, or `structure`, or `event 3 (4 s)`
    quantity: str  # such as `x`, `state`, `share on L1.1`
    expected: str
    got: str
    tolerance: str
    # Expected and got, in `unit`, if they are numbers.
    numbers: tuple[float | None, float | None] = field(default=(None, None), compare=False)
    unit: str = field(default="", compare=False)


PLURAL = {"state": "states", "place": "places", "state and place": "states and places"}


@dataclass(frozen=True, slots=True)
class Unclear:
    """The observations of a run or its golden file that a tiny change may alter, so that they are not compared."""

    states: tuple[str, ...] = ()  # names of bricks
    places: tuple[str, ...] = ()  # names of bricks
    others: tuple[str, ...] = ()  # such as `the height`
    bricks: tuple[str, ...] = ()  # all names, for ranges
    slid: tuple[
        str, ...
    ] = ()  # names among `states` of bricks far from a fall in the run, which may count as displaced

    @property
    def text(self) -> str:
        """Return `1 state and 9 places are unclear and not compared: state of L4.1; places of ...`, or ``."""
        named = [(noun, names) for noun, names in (("state", self.states), ("place", self.places)) if names]
        what = and_text([*(how_many(len(names), noun) for noun, names in named), *self.others])
        if not what:
            return ""
        alone = (len(self.states), len(self.places), len(self.others)) in {(1, 0, 0), (0, 1, 0), (0, 0, 1)}
        if self.states == self.places:
            named = [("state and place", names) for _, names in named[:1]]
        whose = [
            f"{noun if len(names) == 1 else PLURAL[noun]} of {names_text(names, among=self.bricks)}"
            for noun, names in named
        ]
        if self.slid:
            whose.append(f"in this run, only whether displaced: {names_text(self.slid, among=self.bricks)}")
        return f"{what} {'is' if alone else 'are'} unclear and not compared{': ' * bool(whose)}{'; '.join(whose)}"


@dataclass(frozen=True, slots=True)
class FallenCounts:
    """The number of bricks that fell in a run, and those of its golden file, whose unclear states may be falls."""

    golden: int
    unclear: int  # bricks of the golden file whose state is unclear, after a collapse
    now: int
    unclear_now: int = 0  # likewise of the run, where only its snapshot is known
    first: str = ""  # times of the first fall, such as `1.208 s -> 1.167 s`, if they differ within their tolerance

    @property
    def text(self) -> str:
        """Return `38 -> 6 bricks`, or all counts if some are unclear; empty if the run cannot differ."""
        if not (self.unclear or self.unclear_now):
            return "" if self.golden == self.now else f"{self.golden} -> {how_many(self.now, 'brick')}"
        open_now, left = (f", and up to {count} more" * bool(count) for count in (self.unclear_now, self.unclear))
        return f"now {how_many(self.now, 'brick')}{open_now}; the golden has {self.golden} fallen{left}"


@dataclass(frozen=True, slots=True, repr=False)
class GoldenResult(Displayed):
    """The comparison of one snapshot with its file; false unless they agree or the file was just written."""

    status: GoldenStatus
    file: str
    differences: tuple[GoldenDifference, ...] = ()
    note: str = ""  # such as a different stamp, or the reason why the file cannot be read
    digest: str = ""  # SHA-256 of the golden file; empty if there is none
    renamed_from: str = ""  # the file of another name with the same content
    offered: str = field(default="", compare=False)  # text of the new golden file; empty if it is the same
    unclear: Unclear = field(default=Unclear(), compare=False)
    fallen: FallenCounts | None = field(default=None, compare=False)  # None if the file has no states to compare

    @property
    def fallen_text(self) -> str:
        """Return how many bricks fell, after `fallen`; empty without differences, and if the number is the same."""
        text = self.fallen.text if self.fallen is not None and self.differences else ""
        return f"fallen {text}" if text else ""

    def __bool__(self) -> bool:
        """Return whether nothing is left to decide, so that `assert run.golden(directory)` fails on a difference."""
        return self.status not in GOLDEN_FAILURES

    def __repr__(self) -> str:
        """Return the status with the first differences, which pytest shows where an assertion fails."""
        told = [f"{each.quantity} of {each.subject} {each.expected} -> {each.got}" for each in self.differences[:FEW]]
        more = [f"and {count} more"] if (count := len(self.differences[FEW:])) else []
        left = "".join(f"; {each}" for each in (self.fallen_text, self.unclear.text) if told and each)
        return f"<{self.status}: golden file {self.file}{': ' * bool(told)}{', '.join([*told, *more])}{left}>"


@dataclass(frozen=True, slots=True)
class EarlyEndSummary:
    """Rest of a run that ended early, when all claims were decided."""

    time: float  # actual end of the run [s]
    planned: float  # regular end of the run [s]
    actions: int  # remaining actions

    @classmethod
    def by(cls, early: EarlyEnd | None) -> "EarlyEndSummary | None":
        """Return the rest of a run that ended early; None if it did not."""
        return cls(early.time, early.planned, len(early.undone)) if early is not None else None


class RunStatus(StrEnum):
    """How the run of a variant ended."""

    DONE = "done"
    SKIPPED = "skipped"  # a required package is not installed
    BLOCKED = "blocked"  # an action was not possible, since a brick was in its way
    CRASHED = "crashed"
    TIMED_OUT = "timed out"
    NOT_RUN = "not run"  # the call was interrupted before its turn


@dataclass(frozen=True, slots=True)
class VariantResult(Displayed):
    """Result of one variant of a scenario on one system."""

    scenario: str
    variant: str  # such as `step=10mm,thesis`
    system: str
    file: str
    status: RunStatus
    verdict: str = ""  # `stands`, `collapses`, `numerical-collapse`, `unreliable`; empty if it did not run
    numerical: str = ""  # evidence that the solver, not physics, caused the collapse; empty if there is none
    wrong_edges: WrongEdges | None = None  # None if no contact with a wrong normal was observed
    wrong_friction: WrongFriction | None = None  # largest error in the friction of the engine
    touching_within: float = 0.0  # [m] widest gap that the verdict of statics counts as contact; 0 if it counts none
    passed_through: PassedThrough | None = None  # the first thrown brick that passed through another
    energy_gained: float = 0.0  # share of energy that the engine added, if that is a fault
    collapse: Collapse | None = None
    ensemble: Ensemble | None = None  # outcomes of the samples; None for one run
    moving: tuple[BodyId, ...] = ()  # bricks that were moving at the end
    early_end: EarlyEndSummary | None = None  # None if the run went on to its regular end
    drift: float = 0.0  # [m]
    cost: Cost | None = None
    outcomes: tuple[ClaimOutcome, ...] = ()  # expectations
    why: FailureCause | None = None  # None if every expectation is met
    truths: tuple[ClaimOutcome, ...] = ()  # comparison with answers from other sources, which never fails the scenario
    golden: GoldenResult | None = None
    engine: str = ""  # the package that took the steps; empty without steps
    modified: str = ""  # constants of the scene that differ from the file; empty if none does
    message: str = ""  # why it crashed, timed out or was skipped
    remedy: str = ""  # what helps against that
    traceback: str = ""  # of the error that ended it; empty if no error in Python did
    warnings: tuple[ScenarioWarning, ...] = ()  # about its files; they do not fail it
    mistake: Diagnostic | None = None  # cause of a blocked run, with its place in the file
    refinement: tuple[Change, ...] | None = None  # changes in a refined run; None if there was none
    sensitivity: tuple[Change, ...] | None = None  # changes a micrometre to either side; None without these runs
    parameters: tuple[tuple[str, str], ...] = ()  # value from each row of the matrix, as written
    remembered: bool = False  # from the cache, of the same program with the same files
    set_aside: bool = False  # whether the scenario has the mark `skip`
    xfail: str | None = None  # reason of the mark `xfail`; None without the mark
    strict: bool = False  # whether it is a failure to pass despite `xfail`
    must_claim: bool = False  # whether it is a failure to have no expectation

    @property
    def unchecked(self) -> bool:
        """Return whether it ran without expectations, so that any outcome passes."""
        return self.status is RunStatus.DONE and not self.outcomes

    @property
    def fell(self) -> bool:
        """Return whether a brick that came to rest fell, in the run or in any sample."""
        return self.collapse is not None or (self.ensemble is not None and bool(self.ensemble.fell))

    @property
    def passed(self) -> bool:
        """Return whether every expectation is met. A run with refinement must also not have a numerical collapse."""
        if (self.refinement is not None and self.numerical) or (self.must_claim and self.unchecked):
            return False
        return self.status is RunStatus.DONE and all(outcome.passed for outcome in self.outcomes)

    @property
    def is_one_run(self) -> bool:
        """Return whether there was a single, complete run."""
        return self.status is RunStatus.DONE and self.ensemble is None

    @property
    def unexpected(self) -> bool:
        """Return whether it failed without `xfail`, or passed despite a strict `xfail`."""
        if self.must_claim and self.unchecked:
            return True
        if self.xfail is None or self.status is not RunStatus.DONE:
            return not self.passed
        return self.passed and self.strict

    @property
    def may_be_locked(self) -> bool:
        """Return whether the result may be written as a new golden file: it passed, or failed as marked by `xfail`."""
        return self.passed or not self.unexpected

    @property
    def moved(self) -> tuple[Change, ...]:
        """Return the observations that change with refinement."""
        return tuple(change for change in self.refinement or () if change.moved)

    @property
    def decided_by_a_micrometre(self) -> tuple[Change, ...]:
        """Return the observations that change within a micrometre."""
        return tuple(change for change in self.sensitivity or () if change.moved)

    @property
    def name(self) -> str:
        """Return the name for reports: the scenario, then the variant in brackets."""
        return f"{self.scenario}[{self.variant}]"

    @property
    def case(self) -> str:
        """Return the variant without its system, which is the same for runs of one case on several systems."""
        return self.variant.removesuffix(self.system).rstrip(",")

    @property
    def met(self) -> int:
        """Return the number of expectations that are met."""
        return sum(outcome.passed for outcome in self.outcomes)

    @property
    def truth_agrees(self) -> bool | None:
        """Return whether all truths are met; None if there are none."""
        return all(truth.passed for truth in self.truths) if self.truths else None

    @property
    def golden_failed(self) -> bool:
        """Return whether the snapshot and its file do not agree."""
        return self.golden is not None and self.golden.status in GOLDEN_FAILURES

    @property
    def wall_per_simulated(self) -> float | None:
        """Return the wall time per simulated second; None if the run did not finish or took no time."""
        if self.status is not RunStatus.DONE or self.cost is None:
            return None
        cost = self.cost
        return cost.wall_time / cost.simulated_time if min(cost.wall_time, cost.simulated_time) > 0.0 else None

    @property
    def conclusion(self) -> str:
        """Return the category of the result in the summary of a report."""
        if self.status is not RunStatus.DONE:
            return self.status.value
        if self.xfail is not None and not self.golden_failed:
            return "xpassed" if self.passed else "xfailed"
        only_solver = self.refinement is not None and bool(self.numerical)
        if not self.passed and self.xfail is None and (only_solver or not self.unchecked):
            return NUMERICAL_COLLAPSE if self.numerical else UNRELIABLE if self.verdict == UNRELIABLE else "failed"
        shows_golden = self.golden is not None and (
            self.golden_failed or self.golden.status is GoldenStatus.OTHER_ENGINE
        )
        if self.unchecked and (self.must_claim or not shows_golden):
            return UNCHECKED
        return f"golden {self.golden.status.value}" if self.golden is not None and shows_golden else "passed"


@dataclass(frozen=True, slots=True)
class Report:
    """Results of a call, in the order of files, scenarios and systems."""

    results: tuple[VariantResult, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    obsolete: tuple[str, ...] = ()  # golden files without a variant
    removed: tuple[str, ...] = ()  # obsolete golden files that this call removed
    interrupted: bool = False
    left: int = 0  # cases that did not run, since the call stops at the first failure
    accept: str = ""  # the command that accepts all differences from golden files, and removes obsolete ones
    accept_failing: str = "--update --accept-failing"  # the options that also accept results that fail
    review: str = "stackdsl golden review"  # the command that accepts differences one by one; empty if there is none
    wall_time: float = field(default=0.0, compare=False)  # [s]

    @property
    def scenarios(self) -> int:
        """Return the number of scenarios with a result."""
        return len({(result.file, result.scenario) for result in self.results})

    @property
    def conclusions(self) -> Mapping[str, int]:
        """Return the number of variants by conclusion: `passed` first, the rest by name."""
        counts = Counter(result.conclusion for result in self.results)
        return {"passed": counts.pop("passed", 0)} | dict(sorted(counts.items()))

    def speed_up(self, result: VariantResult) -> float | None:
        """Return the ratio of wall times per simulated second, REFERENCE_SYSTEM to `result`, for the same case.

        Times are per simulated second, since a run that collapses early also stops early.
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
    """Return the exit code of a report. Of several reasons, the one that makes the results least trustworthy wins."""
    if report.interrupted:
        return ExitCode.INTERRUPTED
    if report.diagnostics or any(result.status is RunStatus.BLOCKED for result in report.results):
        return ExitCode.INVALID
    executed = [result for result in report.results if result.status is not RunStatus.SKIPPED]
    if any(result.status is not RunStatus.DONE for result in executed):
        return ExitCode.CRASHED
    if not executed and not any(result.set_aside for result in report.results):
        return ExitCode.USAGE
    if any(result.unexpected for result in executed):
        return ExitCode.FAILED
    if report.obsolete or any(result.golden_failed for result in report.results):
        return ExitCode.GOLDEN
    return ExitCode.OK
