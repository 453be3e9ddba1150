"""Systems and assessors of statics, compared through one protocol."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from benchmarks.systems.assessment import Assessment, Assessor, assessed, refusal, why_numerical
from benchmarks.systems.compas import ASSESSORS
from benchmarks.systems.lmgc90 import Lmgc90
from stability.engines.protocol import Package
from stackdsl.judging.judge import with_numerical_collapse
from stackdsl.simulation.known_systems import KNOWN, system_named
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import System
from stackdsl.simulation.worlds import load
from stackdsl.timeline import Timeline
from stackdsl.trace import Trace

# Bare engines that may provide a converged reference, the most trusted first.
REFERENCES = ("tuned", "stock")
NO_STEPS = 0.0  # factor on the time step of an assessor, which has none
Result = Trace | Assessment


class Entrant(Protocol):
    """Participant in the comparison, at a factor on its time step."""

    @property
    def package(self) -> Package:
        """Return the required package."""

    def factors(self, asked: Sequence[float]) -> Sequence[float]:
        """Return those of the requested factors that change its result."""

    def refusal(self, timeline: Timeline) -> str:
        """Return the reason why it cannot play a case; empty if it can."""

    def load(self) -> None:
        """Import the required modules."""

    def play(self, timeline: Timeline, factor: float) -> Result:
        """Play a timeline from the start."""

    def checked(self, result: Result, timeline: Timeline) -> Result:
        """Return the result with the verdict of statics, which is not part of the run."""


@dataclass(frozen=True, slots=True)
class Player:
    """System that plays a timeline in steps."""

    system: System

    @property
    def package(self) -> Package:
        """Return the package of its engine."""
        return self.system.engine.package

    def factors(self, asked: Sequence[float]) -> Sequence[float]:
        """Return all factors."""
        return asked

    def refusal(self, timeline: Timeline) -> str:
        """Return no reason."""
        return ""

    def load(self) -> None:
        """Import its engine, or the proofs that replace it."""
        load(self.system)

    def play(self, timeline: Timeline, factor: float) -> Result:
        """Return a trace."""
        return play(timeline, self.system.at_step(factor))

    def checked(self, result: Result, timeline: Timeline) -> Result:
        """Mark a collapse that statics disproves."""
        return with_numerical_collapse(result, timeline, self.system) if isinstance(result, Trace) else result


@dataclass(frozen=True, slots=True)
class Judge:
    """Assessor without time steps, which judges after each placement."""

    assessor: Assessor

    @property
    def package(self) -> Package:
        """Return the package of the assessor."""
        return self.assessor.package

    def factors(self, asked: Sequence[float]) -> Sequence[float]:
        """Return a single factor."""
        return (NO_STEPS,)

    def refusal(self, timeline: Timeline) -> str:
        """Refuse motion, and all else that the assessor does not support."""
        return refusal(timeline, self.assessor)

    def load(self) -> None:
        """Import its package."""
        self.assessor.load()

    def play(self, timeline: Timeline, factor: float) -> Result:
        """Return an assessment."""
        return assessed(timeline, self.assessor)

    def checked(self, result: Result, timeline: Timeline) -> Result:
        """Mark a fall that statics disproves."""
        if isinstance(result, Trace):
            return result
        return replace(result, numerical=why_numerical(result, timeline))


PLAYERS: Mapping[str, Entrant] = {name: Player(system) for name, system in KNOWN.items()}
_ASSESSORS: tuple[Assessor, ...] = (*ASSESSORS.values(), Lmgc90())
JUDGES: Mapping[str, Entrant] = {assessor.name: Judge(assessor) for assessor in _ASSESSORS}
ENTRANTS: Mapping[str, Entrant] = {**PLAYERS, **JUDGES}  # by name


def entrant_named(name: str) -> Entrant:
    """Return a participant by name, or a system of another package. Raises KeyError or ForeignSystemError."""
    return ENTRANTS[name] if name in ENTRANTS else Player(system_named(name))
