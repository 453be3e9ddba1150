"""What begins is eased in where it has a share of the motion that counts."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import cast

import pytest

from stability.engines.protocol import World
from stability.model import AT_REST, BodyId, BodyState, Pose
from stability.watching.extension import Update
from stackdsl.playing.beginnings import begins_to_matter


@dataclass
class Moving:
    """Bricks of one mass, each at a speed [m/s]."""

    speeds: dict[BodyId, float]

    def masses(self) -> dict[BodyId, float]:
        return dict.fromkeys(self.speeds, 2.0)

    def states(self, bricks: Collection[BodyId]) -> dict[BodyId, BodyState]:
        return {b: BodyState(Pose(AT_REST), (0.0, 0.0, -self.speeds[b]), AT_REST) for b in bricks}


def matters(update: Update, speeds: dict[BodyId, float]) -> bool:
    return begins_to_matter(cast(World, Moving(speeds)), update, list(speeds))


@pytest.mark.parametrize(("others", "does"), [(0, True), (49, True), (51, False)])
def test_a_hit_by_one_of_many_that_fall_as_fast_is_eased_in_up_to_a_fiftieth_of_their_energy(
    others: int, does: bool
) -> None:
    falling = dict.fromkeys(["hammer", *map(str, range(others))], 3.0)
    assert matters(Update(woken=("struck",), by=("hammer",)), {**falling, "struck": 0.0}) == does


def test_bricks_that_have_come_to_rest_take_no_share_of_a_hit() -> None:
    row = dict.fromkeys(map(str, range(500)), 0.0)
    assert matters(Update(woken=("last",), by=("hammer",)), {**row, "hammer": 0.1, "last": 0.0})


def test_what_gives_way_by_itself_is_always_eased_in() -> None:
    falling = dict.fromkeys(map(str, range(500)), 3.0)
    pressed = Update(woken=("a",), by=("7",))
    assert not matters(pressed, falling)
    assert matters(pressed.then(Update(woken=("b",))), falling)
    assert not matters(pressed.then(Update(frozen=("c",))), falling)
