"""Names by place of bricks that come one by one: each is asked for before the next one is known."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from stability.model import BodyId, Plane
from stability.shapes.apart import in_place
from stackdsl.compiling.fitting import CrowdedError, Site
from stackdsl.compiling.naming import CrowdedBrickError, footings_of, level_above, levels_of, name_by_place, names_of
from stackdsl.compiling.written_bricks import NowhereError, WrittenBrick

MAX_NAMED = 20_000  # bricks whose names are worked out anew, as others came to lie under them; a second


@dataclass(slots=True)
class Standing:
    """Levels and names of the bricks so far, as `levels_of` and `names_of` would give them."""

    planes: Sequence[Plane]
    site: Site = field(init=False)
    written: list[WrittenBrick] = field(default_factory=list)
    levels: list[int] = field(default_factory=list)
    counts: Counter[tuple[str, int]] = field(default_factory=Counter)
    named: dict[BodyId, int] = field(default_factory=dict)  # the first brick that is called so, by number
    cost: int = 0  # bricks whose names were worked out anew

    def __post_init__(self) -> None:
        self.site = Site([], self.planes)

    def take_in(self, bricks: Sequence[WrittenBrick], asked: BodyId) -> None:
        """Take in those that are new, as a name is `asked` for. Raises NowhereError if that costs too much."""
        moved = False  # the level of an earlier brick
        for brick in bricks[len(self.written) :]:
            moved = self._add(brick) or moved
        if moved:
            self._name_all(asked)

    def _add(self, brick: WrittenBrick) -> bool:
        """Take in a brick; whether it lies under an earlier one, whose level it changes."""
        number = len(self.written)
        self.written.append(brick)
        self.site.blocks.append(in_place(brick.shape, brick.pose))
        self.levels.append(brick.level or 1)
        try:
            moved = brick.lost is None and self._stand(number, brick)
        except CrowdedError as error:
            raise CrowdedBrickError(brick) from error
        self.named.setdefault(name_by_place(brick, self.levels[number], self.counts), number)
        return moved

    def _stand(self, number: int, brick: WrittenBrick) -> bool:
        self.site.put(number)
        self.levels[number] = brick.level or self._level(number)
        return any(self._is_lifted(other, brick.step) for other in self.site.touching(number))

    def _level(self, number: int) -> int:
        return level_above(number, self.site.fit(number), self.written, self.levels)

    def _is_lifted(self, number: int, step: int) -> bool:
        """Whether a brick has come to stand higher; it rests on what is put in its own step, and on nothing later."""
        brick = self.written[number]
        return brick.step == step and brick.level is None and self._level(number) != self.levels[number]

    def _name_all(self, asked: BodyId) -> None:
        self.cost += len(self.written)
        if self.cost > MAX_NAMED:
            raise NowhereError(asked, too_dear=True)
        self.levels = levels_of(self.written, footings_of(self.written, self.planes))
        self.counts.clear()
        names = names_of(self.written, self.levels, self.counts)
        self.named = {called: number for number, called in reversed(list(enumerate(names)))}
