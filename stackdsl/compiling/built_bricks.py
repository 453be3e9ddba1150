"""Every brick that is built or slid in: on what it stands, at which level, by which name, and while it is there."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from stability.model import BodyId, Plane
from stackdsl.compiling.beside import Surroundings
from stackdsl.compiling.fitting import Fit
from stackdsl.compiling.moment import START, Moment
from stackdsl.compiling.naming import footings_of, levels_of, names_of
from stackdsl.compiling.written_bricks import WrittenBrick, bricks_of
from stackdsl.language.schema import Scenario


class InHand(NamedTuple):
    """When a brick comes, is in its place, and is left to itself [s]: all at once, unless a hand brings it."""

    begins: float
    arrives: float
    let_go: float


AT_ONCE = InHand(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class BuiltBrick:
    """One brick of the structure."""

    written: WrittenBrick
    footing: Fit  # for judging levels; empty where layouts are all there is
    level: int
    name: BodyId
    removed_in: int | None  # the impact that pulls it out, by number
    placed: Moment = START
    gone: Moment | None = None  # when it is pulled out
    in_hand: InHand = AT_ONCE


def built_bricks(scenario: Scenario, planes: Sequence[Plane]) -> list[BuiltBrick]:
    """All bricks in the author's order, not yet with their times."""
    written = bricks_of(scenario, Surroundings(planes))
    removed: Mapping[int, int] = {}
    # Names say what is pulled out, which makes room for what is slid in, whose level then gives it its name.
    for _ in range(2 if scenario.impacts else 1):
        until = {index: len(scenario.build) + number for index, number in removed.items()}
        footings = footings_of(written, planes, until)
        levels = levels_of(written, footings)
        names = names_of(written, levels)
        removed = _removed_in(scenario, names)
    each = enumerate(zip(written, footings, levels, names, strict=True))
    return [BuiltBrick(*known, removed.get(index)) for index, known in each]


def _removed_in(scenario: Scenario, names: Sequence[BodyId]) -> Mapping[int, int]:
    """The impact that pulls out a brick, by the number of the brick."""
    numbers = {name: index for index, name in enumerate(names)} if scenario.impacts else {}
    return {
        numbers[named.name]: number
        for number, impact in enumerate(scenario.impacts)
        for named in impact.done.pulled_out
        if named.name in numbers
    }
