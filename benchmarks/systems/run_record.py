"""One run as plain values: case, system, time step, observations and cost."""

from collections.abc import Mapping
from dataclasses import dataclass

from benchmarks.systems.entrants import NO_STEPS
from stackdsl.results import Seen

NOT_TAKEN = "not taken"  # instead of a RunStatus: the participant does not support such a case


@dataclass(frozen=True, slots=True)
class TruthHeld:
    """One known result compared with the run."""

    kind: str  # such as `height`
    unit: str
    off: float | None  # error in `unit`; None without a distance


@dataclass(frozen=True, slots=True)
class Record:
    """One case on one system at one time step."""

    case: str  # such as `stepped-column[step=10mm]`
    system: str
    factor: float  # factor on the system's own time step, or NO_STEPS
    status: str  # a RunStatus, or NOT_TAKEN
    message: str = ""  # why it is not finished
    numerical: str = ""  # why its collapse is caused by the solver; empty without evidence
    levels: int = 0  # of the whole structure
    observations: Mapping[str, Seen] | None = None  # None if it is not finished
    truths: tuple[TruthHeld, ...] = ()
    wall_time: float = 0.0  # [s], median
    simulated_time: float = 0.0  # [s]
    steps: int = 0  # of the engine
    solves: int = 0  # number of proofs of bricks, repeated ones included
    peak_memory: int = 0  # [bytes]
    update_median: float | None = None  # [s]; None without an extension
    update_worst: float | None = None  # [s]

    @property
    def name(self) -> str:
        """Return the name, such as `slant-tower on exact, step / 2`."""
        return f"{self.case} on {self.system}, {step_text(self.factor)}"

    @property
    def done(self) -> bool:
        """Return whether it was played to its end."""
        return self.observations is not None

    @property
    def taken(self) -> bool:
        """Return whether the participant supports the case."""
        return self.status != NOT_TAKEN

    @property
    def conclusion(self) -> str:
        """Return the verdict and the wall time, or otherwise the status."""
        if self.observations is None:
            return self.status
        return f"{self.observations['verdict']} in {self.wall_time:.3g} s"

    def seen(self, kind: str) -> float | None:
        """Return an observed number."""
        value = None if self.observations is None else self.observations[kind]
        return value if isinstance(value, float) else None


def step_text(factor: float) -> str:
    """Return `step x 2`, `step / 4`: the step relative to the system's own."""
    if factor == NO_STEPS:
        return "no steps"
    if factor >= 1.0:
        return f"step x {factor:g}"
    return f"step / {1.0 / factor:g}"
