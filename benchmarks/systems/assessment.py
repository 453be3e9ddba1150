"""Timeline -> assessment: the verdicts of a method that knows neither motion nor time.

The method judges after every placement and every removal, as exact statics does. Judging only whole levels, or a
bisection, would be cheaper and wrong: a structure that stands in the end need not stand on the way, and vice versa.
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
    JointsAction,
    LoadsAction,
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
    """Input of an assessor."""

    bricks: Sequence[Placed]
    planes: Sequence[Plane]
    friction: float  # Coulomb coefficient of all contacts


class Assessor(Protocol):
    """Decides whether bricks stand at their places."""

    @property
    def name(self) -> str:
        """Return the displayed name."""

    @property
    def package(self) -> Package:
        """Return the required package."""

    def refusal(self, contacts: Sequence[Contact]) -> str:
        """Return the reason why bricks with such contacts cannot be judged; empty if they can."""

    def load(self) -> None:
        """Import the required modules, so that no run includes their time."""

    def stands(self, scene: Scene) -> bool:
        """Return whether all bricks stand."""


@dataclass(frozen=True, slots=True)
class Assessment:
    """Verdicts of an assessor on a whole timeline."""

    level: int | None  # level under construction at the first verdict of a fall; None without one
    time: float  # of the last verdict [s]
    cost: Cost
    numerical: str = ""  # why the verdict is not physical; empty without evidence

    @property
    def observations(self) -> Mapping[str, Seen]:
        """Return whether it stands, and the level: other observations need a motion."""
        told = (
            RunVerdict.STANDS if self.level is None else NUMERICAL_COLLAPSE if self.numerical else RunVerdict.COLLAPSES
        )
        level = None if self.level is None else float(self.level)
        return dict.fromkeys(KINDS) | {"verdict": str(told), "collapse level": level}


def refusal(timeline: Timeline, assessor: Assessor) -> str:
    """Return the reason why an assessor cannot judge a timeline; empty if it can."""
    if any(leaves_to_engine(action) for action in timeline.as_set_down().actions):
        return MOVES
    return assessor.refusal(contacts_in(timeline))


def contacts_in(timeline: Timeline) -> list[Contact]:
    """Return all contacts of a timeline while nothing moves."""
    world = timeline.world
    structure = Structure(world.planes, (), world.friction, world.gravity, world.tolerances)
    for placement in timeline.placements:
        structure.put(Placed(placement.brick, placement.pose))
    return structure.contacts_of(list(structure.bricks))


def assessed(timeline: Timeline, assessor: Assessor) -> Assessment:
    """Judge after every placement and removal up to the first fall."""
    usual = as_friction(timeline.world.friction).usual
    friction = next((contact.law.friction for contact in contacts_in(timeline)), usual)
    started, asked, level = perf_counter(), 0, 0
    there: dict[BodyId, Placed] = {}
    for moment in timeline.as_set_down().moments():
        match moment:
            case Removal():
                there = {name: placed for name, placed in there.items() if name not in moment.bricks}
            case JointsAction() | LoadsAction() | PushAction() | ShakeAction():
                raise ValueError(MOVES)
            case MoveAction() | HoldAction() | ReleaseAction():
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
    """Return why a verdict is not physical: a fall, although statics prove that the structure stands."""
    return DISPROVED if assessment.level is not None and stands_until(timeline, assessment.time) else ""


def _placed(placement: Placement) -> Placed:
    return Placed(placement.brick, placement.pose)


def _cost(assessor: Assessor, wall_time: float, time: float, asked: int) -> Cost:
    """Return the cost; the simulated time is that of the judged part of the timeline."""
    return Cost(wall_time, time, steps=0, judgements=asked, proofs={assessor.name: asked})
