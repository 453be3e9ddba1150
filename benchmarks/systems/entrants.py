"""The systems and the assessors of statics that are held against each other, behind one protocol."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from benchmarks.systems.assessment import Assessment, Assessor, assessed, refusal, why_numerical
from benchmarks.systems.compas import ASSESSORS
from stability.engines.protocol import Package
from stackdsl.judging.judge import with_numerical_collapse
from stackdsl.simulation.known_systems import KNOWN, system_named
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import System
from stackdsl.simulation.worlds import load
from stackdsl.timeline import Timeline
from stackdsl.trace import Trace

# Bare engines that a converged reference may be taken from, the most trusted first.
REFERENCES = ("tuned", "stock")
NO_STEPS = 0.0  # in place of a factor to the time step, of what takes none
Result = Trace | Assessment


class Entrant(Protocol):
    """What is held against the others, at so many times its time step."""

    @property
    def package(self) -> Package:
        """What must be installed."""

    def factors(self, asked: Sequence[float]) -> Sequence[float]:
        """Which of the time steps that were asked for make a difference to it."""

    def refusal(self, timeline: Timeline) -> str:
        """Why it cannot take a case; empty if it can."""

    def load(self) -> None:
        """Import what it needs from the start."""

    def play(self, timeline: Timeline, factor: float) -> Result:
        """One run, from nothing."""

    def checked(self, result: Result, timeline: Timeline) -> Result:
        """The same, with what statics say of it; no part of a run."""


@dataclass(frozen=True, slots=True)
class Player:
    """A system, which plays a timeline in steps."""

    system: System

    @property
    def package(self) -> Package:
        """That of its engine."""
        return self.system.engine.package

    def factors(self, asked: Sequence[float]) -> Sequence[float]:
        """All of them."""
        return asked

    def refusal(self, timeline: Timeline) -> str:
        """None."""
        return ""

    def load(self) -> None:
        """Its engine, or the proofs that may do without."""
        load(self.system)

    def play(self, timeline: Timeline, factor: float) -> Result:
        """A trace."""
        return play(timeline, self.system.at_step(factor))

    def checked(self, result: Result, timeline: Timeline) -> Result:
        """A collapse that statics disprove is marked."""
        return with_numerical_collapse(result, timeline, self.system) if isinstance(result, Trace) else result


@dataclass(frozen=True, slots=True)
class Judge:
    """An assessor, which says whether it stands after each placement, and has no time step."""

    assessor: Assessor

    @property
    def package(self) -> Package:
        """That of the assessor."""
        return self.assessor.package

    def factors(self, asked: Sequence[float]) -> Sequence[float]:
        """One run says all."""
        return (NO_STEPS,)

    def refusal(self, timeline: Timeline) -> str:
        """Motion, and whatever else it knows nothing of."""
        return refusal(timeline, self.assessor)

    def load(self) -> None:
        """Its package."""
        self.assessor.load()

    def play(self, timeline: Timeline, factor: float) -> Result:
        """An assessment."""
        return assessed(timeline, self.assessor)

    def checked(self, result: Result, timeline: Timeline) -> Result:
        """A fall that statics disprove is marked."""
        if isinstance(result, Trace):
            return result
        return replace(result, numerical=why_numerical(result, timeline))


PLAYERS: Mapping[str, Entrant] = {name: Player(system) for name, system in KNOWN.items()}
JUDGES: Mapping[str, Entrant] = {name: Judge(assessor) for name, assessor in ASSESSORS.items()}
ENTRANTS: Mapping[str, Entrant] = {**PLAYERS, **JUDGES}  # by name


def entrant_named(name: str) -> Entrant:
    """One of them, or a system of another package. Raises KeyError or ForeignSystemError if it cannot be had."""
    return ENTRANTS[name] if name in ENTRANTS else Player(system_named(name))
