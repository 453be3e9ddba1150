"""Result of a played case, for programs: outcomes, arrays, tables, and its golden file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import numpy.typing as npt

from stability.model import Pose
from stackdsl.api.python_remedies import in_python
from stackdsl.api.run_table import Row, Table
from stackdsl.api.written import Written, copied, spans_of
from stackdsl.checking.cases import Case, cases_of
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import snapshot_of
from stackdsl.compiler.checks import requirements_of
from stackdsl.diagnostics import Diagnostic
from stackdsl.goldens.golden import check_golden, keeper_of
from stackdsl.judging.judge import compare_with_truth, judge, stop_condition_of
from stackdsl.language.yaml.includes import variables_of
from stackdsl.language.yaml.source import Loaded, Source
from stackdsl.project_file import SCENARIOS, project_of
from stackdsl.report.diagnostics import diagnostic_text
from stackdsl.results import ClaimOutcome, GoldenResult
from stackdsl.trace import BrickTrack, Event, Trace

if TYPE_CHECKING:
    import pandas as pd
    import polars as pl


NOT_OF_THE_RUN: Final = ("expect", "truth", "skip", "xfail")  # keys that do not affect the run


class ScenarioError(ValueError):
    """A scenario is invalid; the text has every mistake with its line of Python."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics = tuple(map(in_python, diagnostics))
        super().__init__("\n\n".join(map(diagnostic_text, self.diagnostics)))


class NotMeasuredError(LookupError):
    """A claim needs a measurement that this run was not asked for."""


class Run:
    """One case and its trace."""

    def __init__(self, case: Case, trace: Trace) -> None:
        self.case = case
        self.trace = trace

    @property
    def verdict(self) -> str:
        """Return the verdict, such as `stands`, `collapses`, `numerical-collapse` or `unreliable`."""
        return self.trace.reported_verdict

    @cached_property
    def outcomes(self) -> tuple[ClaimOutcome, ...]:
        """Return each expectation with the measured value and the margin to its threshold."""
        case = self.case
        return judge(self.trace, case.scenario, case.variant, case.source, case.system)

    @cached_property
    def truths(self) -> tuple[ClaimOutcome, ...]:
        """Return the same for truths, which are known from other sources."""
        return compare_with_truth(self.trace, self.case.scenario, self.case.variant, self.case.source)

    @property
    def passed(self) -> bool:
        """Return whether every expectation holds."""
        return all(outcome.passed for outcome in self.outcomes)

    def judge(self, claim: Written) -> ClaimOutcome:
        """Judge one more claim on this run, such as `stands("all")` or `drift("<= 0.1 mm")`.

        Raises ScenarioError for an invalid claim, and NotMeasuredError for one that needs another run.
        """
        if not isinstance(claim, Mapping):
            wanted = 'a claim, such as stands("all") of stackdsl.api.claims'
            raise TypeError(f"expected {wanted}, not {type(claim).__name__}: {claim!r}")
        source = self.case.written
        values = {key: value for key, value in source.values.items() if key not in NOT_OF_THE_RUN}
        values |= {"expect": [copied(claim)], "systems": [self.case.system]}
        spans = {**source.value_spans, **spans_of([claim], ("expect",))}
        again = Source(source.file, values, spans, {}, variables_of(values), files=source.files)
        cases, mistakes = cases_of(Loaded((again,), ()))
        if mistakes:
            raise ScenarioError(mistakes)
        case = next(one for one in cases if one.identity == self.case.identity)
        self._refuse_unmeasured(case)
        return judge(self.trace, case.scenario, case.variant, case.source, case.system)[0]

    def _refuse_unmeasured(self, other: Case) -> None:
        """Raise NotMeasuredError if a run of the other case would have measured more, or for longer."""
        had, due = requirements_of(self.case.scenario), requirements_of(other.scenario)
        lacking = [
            *sorted(set(due.measures) - set(had.measures)),
            *(f"the margin of {margin}" for margin in sorted(set(due.margins) - set(had.margins))),
            *(["how it begins to fall"] if due.closely and not had.closely else []),
            *(["motion"] if due.watched and not had.watched else []),
            *([f"{due.hold:g} s after the last action"] if due.hold > had.hold else []),
        ]
        if lacking:
            told = f"this run was not asked to show {', '.join(lacking)}"
            raise NotMeasuredError(f"{told}: give the claim in `expect` or `truth` of the scenario, and play it again")

    def golden(self, directory: Path | str, update: bool = False) -> GoldenResult:
        """Compare the run with its golden file, the same as for this scenario in YAML; with `update`, write it.

        A written file names the file of Python, or of YAML beside the project's scenarios, that owns it, so that
        `stackdsl check --update` does not remove it.

        Raises GoldenWriteRefusedError for writing in CI, and ProjectError.
        """
        folder = Path(directory)
        project = project_of([folder])
        scenarios = project.scenarios if project.root is not None else folder.parent / SCENARIOS
        keeper = keeper_of(self.case.source.file, folder, scenarios)
        return check_golden(replace(snapshot_of(self.case, self.trace), kept_by=keeper), folder, update)

    def arrays(self) -> Mapping[str, npt.NDArray[Any]]:
        """Return an array per quantity with one entry per brick, in order of placement.

        `name` and `state` are texts, `level` whole numbers; `placed`, `rest` and `final` are poses, (n, 7): the
        position of the centre of mass in the world frame [m] and the quaternion x, y, z, w; `mass` [kg], `volume` [m3],
        `shift` [m] and `tilt` [rad] after coming to rest, `left_at` [s], nan if the brick never left its place.
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
        """Return one row per brick, in order of placement: name, level, state, end, and displacement [m, rad, s]."""
        return Table(_row(name, track) for name, track in self.trace.tracks.items())

    def events(self) -> Table:
        """Return one row per event: time [s], kind, bricks, and reason."""
        return Table(
            {"time": event.time, "event": event.kind.value, "bricks": " ".join(event.bricks), "reason": event.reason}
            for event in self.trace.events
        )

    def to_pandas(self) -> "pd.DataFrame":
        """Return the table as a data frame of pandas. Raises ImportError if it is not installed."""
        return self.table().to_pandas()

    def to_polars(self) -> "pl.DataFrame":
        """Return the table as a data frame of polars. Raises ImportError if it is not installed."""
        return self.table().to_polars()

    def __repr__(self) -> str:
        return f"<Run of {self.case.name}: {self.verdict}>"


def play(case: Case, on_event: Callable[[Event], None] = lambda event: None) -> Run:
    """Play a case from any source in this process; `on_event` is called with each event.

    Raises BlockedPlacementError if a moved brick blocks an action, and TypeError for anything but a case.
    """
    if not isinstance(case, Case):
        hint = "a scenario plays itself, by its `play`" if hasattr(case, "play_all") else "see `Scenario.cases`"
        raise TypeError(f"expected a case, of `Scenario.cases` or `gather`, not {type(case).__name__}; {hint}")
    return Run(case, play_case(case.timeline, case.system, stop_condition_of(case.scenario, case.system), on_event))


def _row(name: str, track: BrickTrack) -> Row:
    (x, y, z), (qx, qy, qz, qw) = track.final.position_W, track.final.orientation
    place: Row = {"x": x, "y": y, "z": z, "qx": qx, "qy": qy, "qz": qz, "qw": qw}
    end: Row = {"shift": track.shift, "tilt": track.tilt, "left_at": track.left_at, "frozen": track.frozen}
    return {"name": name, "level": track.level, "state": track.state.value, **place, **end}


def _seven(pose: Pose) -> tuple[float, ...]:
    return (*pose.position_W, *pose.orientation)
