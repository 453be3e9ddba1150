"""Timeline -> assessment: what a method says that tells standing from falling, and knows neither motion nor time.

It is asked anew after every placement and every removal, as exact statics is. To ask of whole levels only, or to
bisect, would be cheaper and wrong: what stands in the end need not have stood on the way, nor the other way round.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Protocol

from stability.contact_law import as_friction
from stability.engines.protocol import Package
from stability.model import BodyId, Plane
from stability.problem import Contact, Placed
from stability.statics.structure import Structure
from stackdsl.judging.proofs import DISPROVED, stands_until
from stackdsl.results import KINDS, Seen
from stackdsl.simulation.after_collapse import time_of
from stackdsl.timeline import (
    HoldAction,
    MoveAction,
    Placement,
    PushAction,
    ReleaseAction,
    Removal,
    ShakeAction,
    Timeline,
    leaves_to_engine,
)
from stackdsl.trace import NUMERICAL_COLLAPSE, Cost, RunVerdict

MOVES = "something is dropped, thrown or pushed"


@dataclass(frozen=True, slots=True)
class Scene:
    """What an assessor is asked of."""

    bricks: Sequence[Placed]
    planes: Sequence[Plane]
    friction: float  # Coulomb coefficient of all contacts that there are


class Assessor(Protocol):
    """Tells whether bricks stand where they are, and nothing else."""

    @property
    def name(self) -> str:
        """What people call it."""

    @property
    def package(self) -> Package:
        """What must be installed."""

    def refusal(self, contacts: Sequence[Contact]) -> str:
        """Why it can say nothing of bricks that touch so; empty if it can."""

    def load(self) -> None:
        """Import what it needs, so that no run is charged for it."""

    def stands(self, scene: Scene) -> bool:
        """Whether all of it does."""


@dataclass(frozen=True, slots=True)
class Assessment:
    """What an assessor said of a whole timeline."""

    level: int | None  # under construction when it said that what is there falls; None if it never did
    time: float  # that of the last question [s]
    cost: Cost
    numerical: str = ""  # why what it said is none of physics; empty where nothing says so

    @property
    def observations(self) -> Mapping[str, Seen]:
        """Whether it stands, and the level: all else would take motion to see."""
        told = (
            RunVerdict.STANDS if self.level is None else NUMERICAL_COLLAPSE if self.numerical else RunVerdict.COLLAPSES
        )
        level = None if self.level is None else float(self.level)
        return dict.fromkeys(KINDS) | {"verdict": str(told), "collapse level": level}


def refusal(timeline: Timeline, assessor: Assessor) -> str:
    """Why an assessor can say nothing of a timeline; empty if it can."""
    if any(leaves_to_engine(action) for action in timeline.as_set_down().actions):
        return MOVES
    return assessor.refusal(contacts_in(timeline))


def contacts_in(timeline: Timeline) -> list[Contact]:
    """All contacts that there ever are while nothing moves."""
    world = timeline.world
    structure = Structure(world.planes, (), world.friction, world.gravity, world.tolerances)
    for placement in timeline.placements:
        structure.put(Placed(placement.brick, placement.pose))
    return structure.contacts_of(list(structure.bricks))


def assessed(timeline: Timeline, assessor: Assessor) -> Assessment:
    """Ask after every placement and removal until the answer is that what is there falls."""
    usual = as_friction(timeline.world.friction).usual
    friction = next((contact.law.friction for contact in contacts_in(timeline)), usual)
    started, asked, level = perf_counter(), 0, 0
    there: dict[BodyId, Placed] = {}
    for moment in timeline.as_set_down().moments():
        match moment:
            case Removal():
                there = {name: placed for name, placed in there.items() if name not in moment.bricks}
            case PushAction() | ShakeAction() | MoveAction() | HoldAction() | ReleaseAction():
                raise ValueError(MOVES)
            case _:
                there |= {placement.brick.id: _placed(placement) for placement in moment}
                level = max(level, *(placement.level for placement in moment))
        asked += 1
        if there and not assessor.stands(Scene(tuple(there.values()), timeline.world.planes, friction)):
            time = time_of(moment)
            return Assessment(level, time, _cost(assessor, perf_counter() - started, time, asked))
    cost = _cost(assessor, perf_counter() - started, timeline.end, asked)
    return Assessment(None, timeline.end, cost)


def why_numerical(assessment: Assessment, timeline: Timeline) -> str:
    """Why an answer is none of physics: it falls, says the assessor, where statics prove that it stands."""
    return DISPROVED if assessment.level is not None and stands_until(timeline, assessment.time) else ""


def _placed(placement: Placement) -> Placed:
    return Placed(placement.brick, placement.pose)


def _cost(assessor: Assessor, wall_time: float, time: float, asked: int) -> Cost:
    """Its clock is that of the timeline, as far as it was followed."""
    return Cost(wall_time, time, steps=0, judgements=asked, proofs={assessor.name: asked})
