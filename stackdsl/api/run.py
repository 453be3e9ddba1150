"""The run of a case: its outcomes, arrays and tables, and the comparison with its golden file."""

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn

import numpy as np
import numpy.typing as npt

from stability.model import Pose
from stability.notebook import Display, Displayed, display_of
from stackdsl.api.arguments import with_remedy
from stackdsl.api.cases import OneCase, ScenarioError, one_case
from stackdsl.api.notebook import Several, run_display
from stackdsl.api.run_table import Row, Table
from stackdsl.api.words import CLAIM_WORDS
from stackdsl.api.written import CELL, Written, copied, spans_of
from stackdsl.checking.cases import FUNCTIONS_OF_A_CASE, PICTURES, Case, cases_of
from stackdsl.checking.failure_cause import failure_cause_of
from stackdsl.checking.play_case import play_case, with_margins
from stackdsl.checking.results import judged, missed_by, snapshot_of
from stackdsl.compiler.checks import requirements_of
from stackdsl.diagnostics import unknown_attribute
from stackdsl.goldens.golden import ELSEWHERE, PendingStore, check_golden, is_ci, keeper_of, refusal
from stackdsl.goldens.snapshot import Snapshot
from stackdsl.judging.judge import compare_with_truth, judge, stop_condition_of
from stackdsl.language.yaml.includes import definitions_of
from stackdsl.language.yaml.source import Loaded, Source
from stackdsl.project_file import SCENARIOS, project_of
from stackdsl.results import ClaimOutcome, FailureCause, GoldenResult, VariantResult
from stackdsl.trace import BrickState, BrickTrack, Event, Trace
from stackdsl.wording import MILLIMETRES, level_text

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl


UNCHECKED_RUN: Final = 'has no expectations, so nothing is checked; add expect=[claims.stands("all")]'
NOT_OF_THE_RUN: Final = ("expect", "truth", "skip", "xfail")  # keys that do not affect the run


class NotMeasuredError(LookupError):
    """A claim needs a measurement that this run does not have."""


class UncheckedWarning(UserWarning):
    """A run without expectations is asked whether it passed."""


class Run(Displayed):
    """One case and its trace."""

    def __init__(self, case: Case, trace: Trace) -> None:
        self.case = case
        self.trace = trace

    @property
    def verdict(self) -> "RunVerdict":
        """The verdict of the run, such as `stands`, `collapses`, `numerical-collapse` or `unreliable`."""
        return RunVerdict(self)

    @cached_property
    def outcomes(self) -> Several[ClaimOutcome]:
        """The outcome of each claim under `expect`, with the measured value and the margin to its threshold."""
        return Several(self._judged(self.case, self.trace))

    @cached_property
    def truths(self) -> Several[ClaimOutcome]:
        """The outcome of each claim under `truth`."""
        return Several(compare_with_truth(self.trace, self.case.scenario, self.case.variant, self.case.source))

    def __bool__(self) -> bool:
        """Return whether there are expectations and all hold, so that `assert scenario.play()` fails otherwise."""
        return bool(self._passed())

    @property
    def passed(self) -> bool | None:
        """Return whether every expectation holds; None, with a warning, if there is none and nothing is checked."""
        return self._passed()

    def _passed(self) -> bool | None:
        if not self.outcomes:
            warnings.warn(f"{self.case.name} {UNCHECKED_RUN}", UncheckedWarning, stacklevel=3)
            return None
        return all(outcome.passed for outcome in self.outcomes)

    def judge(self, claim: Written) -> ClaimOutcome:
        """Judge another claim on this run, such as `stands("all")` or `drift("<= 0.1 mm")`.

        Raises ScenarioError if the claim is invalid, and NotMeasuredError if it needs a measurement that this run does
        not have.
        """
        if not isinstance(claim, Mapping):
            wanted = 'a claim, such as claims.stands("all")'
            raise TypeError(f"expected {wanted}, not {type(claim).__name__}: {claim!r}")
        source = self.case.written
        values = {key: value for key, value in source.values.items() if key not in NOT_OF_THE_RUN}
        values |= {"expect": [copied(claim)], "systems": [self.case.system]}
        spans = {**source.value_spans, **spans_of([claim], ("expect",))}
        again = Source(source.file, values, spans, {}, frozenset(definitions_of(values)), files=source.files)
        cases, mistakes = cases_of(Loaded((again,), ()))
        if mistakes:
            raise ScenarioError(mistakes)
        case = next(case for case in cases if case.identity == self.case.identity)
        self._refuse_unmeasured(case)
        return self._judged(case, with_margins(self.trace, case.timeline))[0]

    def _judged(self, case: Case, trace: Trace) -> tuple[ClaimOutcome, ...]:
        """Return the outcomes of the claims of a case on this run, each failure with its cause."""
        outcomes = judge(trace, case.scenario, case.variant, case.source, case.system)
        if all(each.passed for each in outcomes):
            return tuple(outcomes)
        # Another claim may need margins, whose weakest spot is then the cause.
        why = (self.cause if case is self.case else failure_cause_of(case, trace)).why
        return tuple(each if each.passed else replace(each, why=why) for each in outcomes)

    @cached_property
    def _result(self) -> VariantResult:
        return judged(self.case, self.trace)

    @cached_property
    def cause(self) -> FailureCause:
        """The explanation of the outcome: what moves by the proof, the last action before, and what moved first."""
        return failure_cause_of(self.case, self.trace)

    def _refuse_unmeasured(self, other: Case) -> None:
        """Raise NotMeasuredError if a run of the other case would have measured more, or for longer."""
        had, due = requirements_of(self.case.scenario), requirements_of(other.scenario)
        lacking = [
            *sorted(set(due.measures) - set(had.measures)),
            *(["the tests of a protocol"] if set(due.tests) - set(had.tests) else []),
            *(["the onset of a fall"] if due.closely and not had.closely else []),
            *(["motion"] if due.watched and not had.watched else []),
            *([f"{due.hold:g} s after the last action"] if due.hold > had.hold else []),
        ]
        if lacking:
            message = f"this run did not record {', '.join(lacking)}"
            raise NotMeasuredError(
                f"{message}; add the claim to `expect` or `truth` of the scenario, and play it again"
            )

    def snapshot(self) -> Snapshot:
        """Return what a golden file records, for `assert snapshot == golden(snapshot.identity)` in pytest."""
        return replace(snapshot_of(self.case, self.trace), missed=missed_by(self._result))

    def golden(self, directory: Path | str, update: bool = False, accept_failing: bool = False) -> GoldenResult:
        """Compare the run with its golden file in a directory: `assert run.golden("golden")`.

        The result is true if they agree, or if the file was just written. With `update`, a file that differs or is
        missing is written; that of a run that fails its expectations only with `accept_failing`.

        The same scenario in YAML has the same golden file. A written file names its owner, which is this Python file
        or a YAML file outside the scenarios of the project. So `stackdsl check --update` does not remove it.

        A difference is pending, as after `stackdsl check`: `stackdsl golden review` shows it. In CI, it is not stored.

        Raises GoldenWriteRefusedError if `update` is set in CI, and ProjectError if the project file is invalid.
        """
        folder = Path(directory)
        project = project_of([folder])
        scenarios = project.scenarios if project.root is not None else folder.parent / SCENARIOS
        file = self.case.source.file
        keeper = ELSEWHERE if file.startswith(CELL) else keeper_of(file, folder, scenarios)
        snapshot = replace(self.snapshot(), kept_by=keeper)
        refused = update and bool(snapshot.missed) and not accept_failing
        found = check_golden(snapshot, folder, update and not refused)
        if not is_ci(os.environ):
            PendingStore(project.state(folder), folder).note(self.case.name, found, snapshot.missed)
        return replace(found, note=refusal(snapshot, "accept_failing=True")) if refused and not found else found

    def arrays(self) -> Mapping[str, npt.NDArray[Any]]:
        """Return one array per quantity, with one entry per brick in order of placement.

        `name` and `state` are strings, `level` integers. `placed`, `rest` and `final` are poses of shape (n, 7): the
        position of the centre of mass in the world frame [m], and the quaternion x, y, z, w. The others are `mass`
        [kg], `volume` [m3], `shift` [m] and `tilt` [rad] since the brick came to rest, and `left_at` [s], nan if the
        brick did not leave its place. Poses, shift and tilt of an `unplaced` brick are nan.
        """
        tracks = list(self.trace.tracks.values())
        was_placed = np.array([track.state is not BrickState.UNPLACED for track in tracks], dtype=bool)

        def measured(values: Sequence[object]) -> npt.NDArray[Any]:
            """Return a row per brick, nan for bricks that were never placed; the trace has their planned poses."""
            rows = np.array(values, dtype=float)
            rows[~was_placed] = np.nan
            return rows

        poses = {name: [_seven(getattr(track, name)) for track in tracks] for name in ("placed", "rest", "final")}
        return {
            "name": np.array([track.brick.id for track in tracks], dtype=str),
            "level": np.array([track.level for track in tracks], dtype=int),
            "state": np.array([track.state.value for track in tracks], dtype=str),
            "mass": np.array([track.brick.mass for track in tracks], dtype=float),
            "volume": np.array([track.brick.shape.volume for track in tracks], dtype=float),
            **{name: measured(of).reshape(-1, 7) for name, of in poses.items()},
            "shift": measured([track.shift for track in tracks]),
            "tilt": measured([track.tilt for track in tracks]),
            "left_at": np.array([np.nan if t.left_at is None else t.left_at for t in tracks], dtype=float),
        }

    def table(self, full: bool = False) -> Table:
        """Return one row per brick in order of placement: name, level, state, final centre of mass, shift and tilt.

        `state` is a `BrickState`, such as `frozen` (stands, proven), `standing` (stands, not proven) or `fallen`.
        Shift and tilt are the largest over the run. Place, shift and tilt of an `unplaced` brick are None. `full` adds
        shift and tilt at the end, the final orientation as a quaternion x, y, z, w, the time at which the brick
        counted as fallen, None if it did not, whether it is held fixed at the end, where it stands or lies, and by how
        much a fallen brick sank, moved or tilted. Columns with a unit end in it: `x_mm`, `tilt_deg`.
        """
        return Table(_row(name, track, full) for name, track in self.trace.tracks.items())

    def events(self) -> Table:
        """Return one row per event: time, kind of event, bricks, reason.

        `frozen` bricks are at rest: they stand by the proof that `reason` names, or, where it is `lies at rest`, they
        had fallen, or were thrown or dropped.
        """
        return Table(
            {
                "time_s": event.time,
                "event": event.kind.value,
                "bricks": " ".join(event.bricks),
                "reason": "lies at rest" if event.lying else event.reason,
            }
            for whole in self.trace.events
            for event in whole.parts
        )

    def to_pandas(self) -> "pd.DataFrame":
        """Return `table` as a pandas data frame. Raises ImportError if pandas is not installed."""
        return self.table().to_pandas()

    def to_polars(self) -> "pl.DataFrame":
        """Return `table` as a polars data frame. Raises ImportError if polars is not installed."""
        return self.table().to_polars()

    def __repr__(self) -> str:
        """Return the failed expectations and their cause, or the verdict; pytest shows it where an assertion fails."""
        failed = [outcome for outcome in self.outcomes if not outcome.passed]
        told = "; ".join(f"{each.name}: expected {each.expected}, measured {each.measured}" for each in failed)
        why = f", why: {cause}" if (failed or self.trace.collapse) and (cause := self.cause.why) else ""
        unchecked = "" if self.outcomes else "unchecked: "
        return f"<{self.case.name} {unchecked or 'failed: ' * bool(told)}{told or self.verdict}{why}>"

    if not TYPE_CHECKING:  # with `__getattr__`, type checkers would accept any name

        def __getattr__(self, name: str) -> NoReturn:
            """Raise AttributeError, which says what to write instead."""
            functions = (each for each in FUNCTIONS_OF_A_CASE if each != "play")
            remedies = {each: f"write `{each}(run.case)` with {each} of stackdsl" for each in functions}
            remedies |= {"play": "write `play(run.case)` with play of stackdsl to play the case again"}
            remedies |= {"margin": remedies["margins"], "to_csv": "write `run.table().to_csv(path)`"}
            remedies |= {each: f"write `run.judge(claims.{each}(...))`" for each in CLAIM_WORDS.names()}
            remedies |= {"height": 'write `run.judge(claims.height(">= 0 mm")).value`'}
            remedies |= dict.fromkeys(
                PICTURES, "a notebook shows the replay of a run; write `run` as the last line of a cell"
            )
            raise unknown_attribute(self, name, remedies)


class RunVerdict(str):
    """The verdict of a run. A comparison of it in a failed assertion of pytest has the cause."""

    __slots__ = ("_run",)
    _run: Run

    def __new__(cls, run: Run) -> "RunVerdict":
        """Return the verdict of a run."""
        verdict = super().__new__(cls, run.trace.reported_verdict)
        verdict._run = run
        return verdict

    def __reduce__(self) -> tuple[type[str], tuple[str]]:
        """Return the text alone, since a run is large."""
        return str, (str(self),)

    def unlike(self, expected: object) -> Sequence[str]:
        """Return the lines of a failed comparison: the case, expected, measured, why, after and first to move."""
        collapse, cause = self._run.trace.collapse, self._run.cause
        where = f" at {level_text(collapse.level, collapse.step)}" if collapse is not None else ""
        lines = {"expected": str(expected), "measured": f"{self}{where}"}
        if collapse is not None:
            lines |= {"why": cause.why, "after": cause.before, "first": cause.first}
        return [self._run.case.name, *(f"  {label:<8}  {text}" for label, text in lines.items() if text)]


@display_of.register
def _(run: Run) -> Display:
    return run_display(run.case, run.trace)


@with_remedy("such as play(scenario), or play(case) for a case of scenario.cases")
def play(case: OneCase, on_event: Callable[[Event], None] = lambda event: None) -> Run:
    """Play a case in this process; `on_event` is called with each event as it happens.

    The case comes from `load`, which reads YAML, or from `Scenario.cases`; a scenario with one case stands for it.
    Raises BlockedPlacementError if a brick has moved into the way of an action, LookupError unless there is exactly one
    case, and TypeError for other values.
    """
    case = one_case(case)
    return Run(case, play_case(case.timeline, case.system, stop_condition_of(case.scenario, case.system), on_event))


def _row(name: str, track: BrickTrack, full: bool) -> Row:
    measured = dict(zip(("x_mm", "y_mm", "z_mm"), (MILLIMETRES * at for at in track.final.position_W), strict=True))
    measured |= {"shift_mm": MILLIMETRES * track.shift, "tilt_deg": degrees(track.tilt)}
    if full:
        measured |= {"end_shift_mm": MILLIMETRES * track.end_shift, "end_tilt_deg": degrees(track.end_tilt)}
        measured |= zip(("qx", "qy", "qz", "qw"), track.final.orientation, strict=True)
    unplaced = track.state is BrickState.UNPLACED  # the poses are then those of the plan
    row: Row = {"name": name, "level": track.level, "state": track.state.value}
    row |= dict.fromkeys(measured) if unplaced else measured
    return {**row, "left_at_s": track.left_at, "frozen": track.frozen, "fell_by": track.fell_by} if full else row


def _seven(pose: Pose) -> tuple[float, ...]:
    return (*pose.position_W, *pose.orientation)
