"""All that a scenario builds, throws and does, and when: what its checks look at, and what its timeline is made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from stability.model import Brick, Plane
from stackdsl.compiling.built_bricks import BuiltBrick, built_bricks
from stackdsl.compiling.moment import Moment
from stackdsl.compiling.scheduling import Schedule, scheduled
from stackdsl.compiling.site import planes_of
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Source


@dataclass(frozen=True, slots=True)
class Built:
    """A scenario with every name and every time resolved, in the frame of the scene."""

    bricks: Sequence[BuiltBrick]  # in the author's order
    missiles: Mapping[int, Brick]  # what is thrown or dropped, by the number of the impact
    impacts: Sequence[Moment]  # when each begins
    shaken: Moment | None  # when the ground begins to move, if it does
    planes: Sequence[Plane]
    mistimed: Sequence[Diagnostic]  # what has no time; then the times are wrong, and nothing fits

    @property
    def in_order(self) -> list[BuiltBrick]:
        """The bricks by when they are placed, then in the author's order."""
        return sorted(self.bricks, key=lambda brick: brick.placed)

    @property
    def levels(self) -> int:
        """The highest level."""
        return max((brick.level for brick in self.bricks), default=0)


def built_of(scenario: Scenario, source: Source) -> Built:
    """What is built and done, as far as it can be said."""
    planes = tuple(planes_of(scenario))
    bricks = built_bricks(scenario, planes)
    schedule = scheduled(bricks, scenario, source)
    return Built(
        bricks=[_timed(brick, number, schedule) for number, brick in enumerate(bricks)],
        missiles=missiles_of(scenario),
        impacts=schedule.impacts,
        shaken=schedule.shaken,
        planes=planes,
        mistimed=schedule.mistakes,
    )


def missiles_of(scenario: Scenario) -> dict[int, Brick]:
    """The bricks that are thrown or dropped, by the number of the impact; `thrown-1` if the first has no name."""
    found = {}
    for number, impact in enumerate(scenario.impacts):
        missile = impact.done.missile
        if missile is not None:
            kind = missile.brick or scenario.brick
            name = missile.name or f"{missile.how}-{number + 1}"
            found[number] = Brick(name, kind.form.shape, kind.mass_of(kind.form))
    return found


def _timed(brick: BuiltBrick, number: int, schedule: Schedule) -> BuiltBrick:
    gone = None if brick.removed_in is None else schedule.impacts[brick.removed_in]
    return replace(brick, placed=schedule.bricks[number], gone=gone, in_hand=schedule.in_hands[number])
