"""Timeline -> what is built in the end, as one design that statics can be asked about."""

from dataclasses import dataclass

from stability.model import BodyId
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed, Stability
from stability.statics.mending.piling import Piling
from stackdsl.timeline import Removal, Timeline


@dataclass(frozen=True, slots=True)
class Design:
    """All that is set down and not pulled out again."""

    assembly: Assembly
    left_out: (
        int  # bricks that are dropped, thrown or let go in the air: where they come to lie only an engine can tell
    )

    @property
    def why_not(self) -> str:
        """Why nothing can be asked of what stands; empty if it does."""
        verdict = self.assembly.verdict()
        if not self.assembly.bricks:
            return "nothing is set down at rest, so there is nothing that statics could judge"
        if verdict.stability is not Stability.STABLE:
            return f"{verdict.stability.upper()}: {verdict.reason}; `stackdsl suggest` looks for what would mend it"
        return ""


def design_of(timeline: Timeline) -> Design:
    """The finished structure of a timeline, all at once."""
    final = timeline.as_set_down()
    gone = {name for action in final.actions if isinstance(action, Removal) for name in action.bricks}
    staying = [placement for placement in final.placements if placement.brick.id not in gone]
    assembly = timeline.world.assembly()
    resting = [Placed(each.brick, each.pose) for each in staying if each.at_rest]
    if resting:
        assembly.add_all(resting)
    return Design(assembly, len(staying) - len(resting))


def piling_of(timeline: Timeline) -> Piling:
    """What is set down and pulled out, in the order of the build."""
    stages: list[list[Placed]] = []
    pulled: dict[int, list[BodyId]] = {}
    there: set[BodyId] = set()
    for moment in timeline.as_set_down().moments():
        if isinstance(moment, Removal):
            # What was dropped or thrown is nowhere that statics know of.
            pulled.setdefault(len(stages), []).extend(name for name in moment.bricks if name in there)
        elif isinstance(moment, tuple):
            stage = [Placed(each.brick, each.pose) for each in moment if each.at_rest]
            stages += [stage] if stage else []
            there.update(placed.brick.id for placed in stage)
    stages += [[]] if len(stages) in pulled else []
    world = timeline.world
    gone = {turn: names for turn, names in pulled.items() if names}
    return Piling(world.planes, world.friction, world.gravity, stages, gone, world.tolerances)
