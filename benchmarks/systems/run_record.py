"""One run as plain values: which case on which system at which time step, what was observed, and what it cost."""

from collections.abc import Mapping
from dataclasses import dataclass

from benchmarks.systems.entrants import NO_STEPS
from stackdsl.results import Seen

NOT_TAKEN = "not taken"  # in place of a RunStatus: the entrant says nothing of such a case


@dataclass(frozen=True, slots=True)
class TruthHeld:
    """One answer known from outside, held against the run."""

    kind: str  # such as `height`
    unit: str
    off: float | None  # distance from what is true, in `unit`; None where it has none


@dataclass(frozen=True, slots=True)
class Record:
    """One case on one system at one time step."""

    case: str  # such as `stepped-column[step=10mm]`
    system: str
    factor: float  # times the system's own time step, or NO_STEPS
    status: str  # a RunStatus, or NOT_TAKEN
    message: str = ""  # why it is not done
    numerical: str = ""  # why its collapse is the solver's; empty where nothing says so
    levels: int = 0  # of the whole structure
    observations: Mapping[str, Seen] | None = None  # None if it is not done
    truths: tuple[TruthHeld, ...] = ()
    wall_time: float = 0.0  # [s], median
    simulated_time: float = 0.0  # [s]
    steps: int = 0  # of the engine
    solves: int = 0  # bricks proven to stand, each as often as it was
    peak_memory: int = 0  # [bytes]
    update_median: float | None = None  # [s]; None of what has no extension
    update_worst: float | None = None  # [s]

    @property
    def name(self) -> str:
        """`slant-tower on exact, step / 2`."""
        return f"{self.case} on {self.system}, {step_text(self.factor)}"

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
        """The verdict and the wall time, or else the status."""
        if self.observations is None:
            return self.status
        return f"{self.observations['verdict']} in {self.wall_time:.3g} s"

    def seen(self, kind: str) -> float | None:
        """A number that was observed."""
        value = None if self.observations is None else self.observations[kind]
        return value if isinstance(value, float) else None


def step_text(factor: float) -> str:
    """`step x 2`, `step / 4`: the length of a step beside the system's own."""
    if factor == NO_STEPS:
        return "no steps"
    if factor >= 1.0:
        return f"step x {factor:g}"
    return f"step / {1.0 / factor:g}"
