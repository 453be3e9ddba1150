"""One run of a bench as plain values, one line of JSON each, so that what was done outlives an interruption."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from math import isfinite

from stackdsl.bench.entrants import NO_STEPS
from stackdsl.results import Seen

NOT_TAKEN = "not taken"  # in place of a RunStatus: the entrant says nothing of such a case
FORMAT = 3  # of a line; raise it whenever an older one can no longer be read


class MalformedRecordError(ValueError):
    """A line that is no record, such as one that was cut off."""


@dataclass(frozen=True, slots=True)
class TruthHeld:
    """One answer known from outside, held against the run."""

    kind: str  # such as `height`
    unit: str
    off: float | None  # distance from what is true, in `unit`; None where it has none
    agrees: bool


@dataclass(frozen=True, slots=True)
class Record:
    """One case on one system at one time step."""

    id: str  # of what was played, and with which settings; the same on every machine
    case: str  # such as `stepped-column[step=10mm]`
    file: str
    system: str
    factor: float  # times the system's own time step, or NO_STEPS
    settings: Mapping[str, float | bool | str | None]  # of the engine
    versions: Mapping[str, str]  # of what it was played with
    status: str  # a RunStatus, or NOT_TAKEN
    message: str = ""  # why it is not done
    numerical: str = ""  # why its collapse is the solver's; empty where nothing says so
    levels: int = 0  # of the whole structure
    observations: Mapping[str, Seen] | None = None  # None if it is not done
    truths: tuple[TruthHeld, ...] = ()
    wall_time: float = 0.0  # [s], median
    runs: int = 0  # that it is the median of
    simulated_time: float = 0.0  # [s]
    steps: int = 0  # of the engine
    judgements: int = 0  # passes of a stability extension
    solves: int = 0  # bricks proven to stand, each as often as it was
    peak_memory: int = 0  # [bytes]
    update_median: float | None = None  # [s]; None of what has no extension
    update_worst: float | None = None  # [s]

    @property
    def name(self) -> str:
        """What people call it."""
        return job_title(self.case, self.system, self.factor)

    @property
    def done(self) -> bool:
        """Whether it was played to its end."""
        return self.observations is not None

    @property
    def taken(self) -> bool:
        """Whether it was to be played at all."""
        return self.status != NOT_TAKEN

    @property
    def conclusion(self) -> str:
        """What came of it, in a word."""
        if self.observations is None:
            return self.status
        return f"{self.observations['verdict']} in {self.wall_time:.3g} s"

    def seen(self, kind: str) -> float | None:
        """A number that was observed."""
        value = None if self.observations is None else self.observations[kind]
        return value if isinstance(value, float) else None


def job_title(case: str, system: str, factor: float) -> str:
    """`slant-tower on exact, step / 2`."""
    return f"{case} on {system}, {step_text(factor)}"


def step_text(factor: float) -> str:
    """`step x 2`, `step / 4`: how long one is, as people say it."""
    if factor == NO_STEPS:
        return "no steps"
    if factor >= 1.0:
        return f"step x {factor:g}"
    return f"step / {1.0 / factor:g}"


def line_of(record: Record) -> str:
    """One line, without its end."""
    return json.dumps({"format": FORMAT} | asdict(record), sort_keys=True, default=str)


def record_of(line: str) -> Record:
    """The record of a line."""
    try:
        values = json.loads(line)
        if values.pop("format") != FORMAT:
            raise MalformedRecordError("it is of another format")
        values["truths"] = tuple(TruthHeld(**truth) for truth in values["truths"])
        if values["observations"] is not None:
            values["observations"] = {kind: _seen(seen) for kind, seen in values["observations"].items()}
        if set(values) != {field.name for field in fields(Record)}:
            raise MalformedRecordError("its keys are not those of a record")
        return Record(**values)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise MalformedRecordError(f"no record: {error}") from error


def _seen(value: object) -> Seen:
    if isinstance(value, list):
        return tuple(str(name) for name in value)
    if isinstance(value, int | float):
        return float(value)
    return value if isinstance(value, str) else None


def finite(value: float) -> float | None:
    """A number that JSON knows, or none."""
    return value if isfinite(value) else None
