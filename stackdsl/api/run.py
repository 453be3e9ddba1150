"""The run of a case: its outcomes, arrays and tables, and the comparison with its golden file."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from stability.model import Pose
from stability.notebook import Display, Displayed, display_of
from stackdsl.api.notebook import Several, run_display
from stackdsl.api.python_remedies import in_python
from stackdsl.api.run_table import Row, Table
from stackdsl.api.written import CELL, Written, copied, spans_of
from stackdsl.checking.cases import Case, cases_of
from stackdsl.checking.failure_cause import failure_cause_of
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import snapshot_of
from stackdsl.compiler.checks import requirements_of
from stackdsl.diagnostics import Diagnostic
from stackdsl.goldens.golden import ELSEWHERE, check_golden, keeper_of
from stackdsl.judging.judge import compare_with_truth, judge, stop_condition_of
from stackdsl.language.yaml.includes import variables_of
from stackdsl.language.yaml.source import Loaded, Source
from stackdsl.project_file import SCENARIOS, project_of
from stackdsl.report.diagnostics import diagnostic_text
from stackdsl.report.text import cause_text
from stackdsl.results import ClaimOutcome, GoldenResult
from stackdsl.trace import BrickTrack, Event, Trace

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl


NOT_OF_THE_RUN: Final = ("expect", "truth", "skip", "xfail")  # keys that do not affect the run


class ScenarioError(ValueError):
    """A scenario is invalid. The text has every mistake with its line of Python."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics = tuple(map(in_python, diagnostics))
        super().__init__("\n\n".join(map(diagnostic_text, self.diagnostics)))


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
    def verdict(self) -> str:
        """The verdict of the run, such as `stands`, `collapses`, `numerical-collapse` or `unreliable`."""
        return self.trace.reported_verdict

    @cached_property
    def outcomes(self) -> Several[ClaimOutcome]:
        """The outcome of each claim under `expect`, with the measured value and the margin to its threshold."""
        case = self.case
        return Several(judge(self.trace, case.scenario, case.variant, case.source, case.system))

    @cached_property
    def truths(self) -> Several[ClaimOutcome]:
        """The outcome of each claim under `truth`."""
        return Several(compare_with_truth(self.trace, self.case.scenario, self.case.variant, self.case.source))

    @property
    def passed(self) -> bool:
        """Return whether every expectation holds; warn if there is none, since nothing is checked then."""
        if not self.outcomes:
            warnings.warn(
                f"{self.case.name} has no expectations, so nothing is checked", UncheckedWarning, stacklevel=2
            )
        return all(outcome.passed for outcome in self.outcomes)

    def judge(self, claim: Written) -> ClaimOutcome:
        """Judge another claim on this run, such as `stands("all")` or `drift("<= 0.1 mm")`.

        Raises ScenarioError if the claim is invalid, and NotMeasuredError if it needs a measurement that this run does
        not have.
        """
        if not isinstance(claim, Mapping):
            wanted = 'a claim, such as stands("all") from stackdsl.api.claims'
            raise TypeError(f"expected {wanted}, not {type(claim).__name__}: {claim!r}")
        source = self.case.written
        values = {key: value for key, value in source.values.items() if key not in NOT_OF_THE_RUN}
        values |= {"expect": [copied(claim)], "systems": [self.case.system]}
        spans = {**source.value_spans, **spans_of([claim], ("expect",))}
        again = Source(source.file, values, spans, {}, variables_of(values), files=source.files)
        cases, mistakes = cases_of(Loaded((again,), ()))
        if mistakes:
            raise ScenarioError(mistakes)
        case = next(case for case in cases if case.identity == self.case.identity)
        self._refuse_unmeasured(case)
        return judge(self.trace, case.scenario, case.variant, case.source, case.system)[0]

    def _refuse_unmeasured(self, other: Case) -> None:
        """Raise NotMeasuredError if a run of the other case would have measured more, or for longer."""
        had, due = requirements_of(self.case.scenario), requirements_of(other.scenario)
        lacking = [
            *sorted(set(due.measures) - set(had.measures)),
            *(f"the margin of {margin}" for margin in sorted(set(due.margins) - set(had.margins))),
            *(["the onset of a fall"] if due.closely and not had.closely else []),
            *(["motion"] if due.watched and not had.watched else []),
            *([f"{due.hold:g} s after the last action"] if due.hold > had.hold else []),
        ]
        if lacking:
            message = f"this run did not record {', '.join(lacking)}"
            raise NotMeasuredError(
                f"{message}; add the claim to `expect` or `truth` of the scenario, and play it again"
            )

    def golden(self, directory: Path | str, update: bool = False) -> GoldenResult:
        """Compare the run with its golden file in a directory; with `update`, write that file.

        The same scenario in YAML has the same golden file. A written file names its owner, which is this Python file
        or a YAML file outside the scenarios of the project. So `stackdsl check --update` does not remove it.

        Raises GoldenWriteRefusedError if `update` is set in CI, and ProjectError if the project file is invalid.
        """
        folder = Path(directory)
        project = project_of([folder])
        scenarios = project.scenarios if project.root is not None else folder.parent / SCENARIOS
        file = self.case.source.file
        keeper = ELSEWHERE if file.startswith(CELL) else keeper_of(file, folder, scenarios)
        return check_golden(replace(snapshot_of(self.case, self.trace), kept_by=keeper), folder, update)

    def arrays(self) -> Mapping[str, npt.NDArray[Any]]:
        """Return one array per quantity, with one entry per brick in order of placement.

        `name` and `state` are strings, `level` integers. `placed`, `rest` and `final` are poses of shape (n, 7): the
        position of the centre of mass in the world frame [m], and the quaternion x, y, z, w. The others are `mass`
        [kg], `volume` [m3], `shift` [m] and `tilt` [rad] since the brick came to rest, and `left_at` [s], nan if the
        brick did not leave its place.
        """
        tracks = list(self.trace.tracks.values())
        poses = {name: [getattr(track, name) for track in tracks] for name in ("placed", "rest", "final")}
        return {
            "name": np.array([track.brick.id for track in tracks], dtype=str),
            "level": np.array([track.level for track in tracks], dtype=int),
            "state": np.array([track.state.value for track in tracks], dtype=str),
            "mass": np.array([track.brick.mass for track in tracks], dtype=float),
            "volume": np.array([track.brick.shape.volume for track in tracks], dtype=float),
            **{name: np.array([_seven(pose) for pose in of], dtype=float).reshape(-1, 7) for name, of in poses.items()},
            "shift": np.array([track.shift for track in tracks], dtype=float),
            "tilt": np.array([track.tilt for track in tracks], dtype=float),
            "left_at": np.array([np.nan if t.left_at is None else t.left_at for t in tracks], dtype=float),
        }

    def table(self) -> Table:
        """Return one row per brick in order of placement: name, level, state, final pose, shift, tilt [m, rad, s]."""
        return Table(_row(name, track) for name, track in self.trace.tracks.items())

    def events(self) -> Table:
        """Return one row per event: time [s], kind of event, bricks, reason."""
        return Table(
            {"time": event.time, "event": event.kind.value, "bricks": " ".join(event.bricks), "reason": event.reason}
            for event in self.trace.events
        )

    def to_pandas(self) -> "pd.DataFrame":
        """Return `table` as a pandas data frame. Raises ImportError if pandas is not installed."""
        return self.table().to_pandas()

    def to_polars(self) -> "pl.DataFrame":
        """Return `table` as a polars data frame. Raises ImportError if polars is not installed."""
        return self.table().to_polars()

    def __repr__(self) -> str:
        """Return the failed expectations and their cause, or the verdict; pytest shows it where an assertion fails."""
        failed = "; ".join(map(repr, (outcome for outcome in self.outcomes if not outcome.passed)))
        cause = f", because {why}" if failed and (why := cause_text(failure_cause_of(self.case, self.trace))) else ""
        return f"<Run of {self.case.name}: {failed or self.verdict}{cause}>"


@display_of.register
def _(run: Run) -> Display:
    return run_display(run.case, run.trace)


def play(case: Case, on_event: Callable[[Event], None] = lambda event: None) -> Run:
    """Play a case in this process; `on_event` is called with each event as it happens.

    The case may come from `Scenario.cases` or from `gather`, which reads YAML. Raises BlockedPlacementError if a brick
    has moved into the way of an action, and TypeError if `case` is not a Case.
    """
    if not isinstance(case, Case):
        hint = "call the `play` method of the scenario" if hasattr(case, "play_all") else "see `Scenario.cases`"
        raise TypeError(f"expected a case from `Scenario.cases` or `gather`, not {type(case).__name__}; {hint}")
    return Run(case, play_case(case.timeline, case.system, stop_condition_of(case.scenario, case.system), on_event))


def _row(name: str, track: BrickTrack) -> Row:
    (x, y, z), (qx, qy, qz, qw) = track.final.position_W, track.final.orientation
    place: Row = {"x": x, "y": y, "z": z, "qx": qx, "qy": qy, "qz": qz, "qw": qw}
    end: Row = {"shift": track.shift, "tilt": track.tilt, "left_at": track.left_at, "frozen": track.frozen}
    return {"name": name, "level": track.level, "state": track.state.value, **place, **end}


def _seven(pose: Pose) -> tuple[float, ...]:
    return (*pose.position_W, *pose.orientation)
