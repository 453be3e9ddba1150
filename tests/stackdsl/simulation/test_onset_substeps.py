"""Sub-steps for the onset of a motion, if it has a notable share of the kinetic energy."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import cast

import pytest

from stability.engines.lazy_world import RestingWorld
from stability.engines.protocol import World
from stability.model import AT_REST, BodyId, BodyState, Pose
from stability.stabilizers.protocol import Update
from stackdsl.simulation import stabilizer_calls as room
from stackdsl.simulation.runner import play
from stackdsl.simulation.stabilizer_calls import CROWD, EaseInPolicy
from stackdsl.simulation.systems import SYSTEMS
from tests.stackdsl.simulation.let_go import FLAT, let_go, over, set_down


@dataclass
class Moving:
    """Bricks of one mass, each at a speed [m/s]."""

    speeds: dict[BodyId, float]

    def masses(self) -> dict[BodyId, float]:
        return dict.fromkeys(self.speeds, 2.0)

    def states(self, bricks: Collection[BodyId]) -> dict[BodyId, BodyState]:
        return {b: BodyState(Pose(AT_REST), (0.0, 0.0, -self.speeds[b]), AT_REST) for b in bricks}


def seen(*looks: dict[BodyId, float]) -> EaseInPolicy:
    """All that moves, as it was seen at some looks [m/s] of which the last is now."""
    beginnings = EaseInPolicy(cast(World, Moving(looks[-1])))
    for speeds in looks:
        beginnings.look(Moving(speeds).states(list(speeds)))
    return beginnings


def matters(update: Update, speeds: dict[BodyId, float]) -> bool:
    return seen(speeds).matters(update, list(speeds))


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


HIT = Update(woken=("struck",), by=("last",))


def heap(others: int, speed: float) -> dict[BodyId, float]:
    """One plank at 0.3 m/s and so many others at a speed [m/s]; with what it hits."""
    return {**dict.fromkeys(map(str, range(others)), speed), "last": 0.3, "struck": 0.0}


@pytest.mark.parametrize(("others", "does"), [(CROWD - 1, True), (CROWD, False)])
def test_of_a_crowd_that_has_come_down_the_last_that_slides_is_not_eased_in(others: int, does: bool) -> None:
    has_fallen = seen(heap(others, 3.0), heap(others, 0.0))
    assert has_fallen.matters(HIT, list(heap(others, 0.0))) == does


def test_a_row_of_many_is_eased_in_where_its_foremost_has_its_share_of_all_that_ever_moved_at_once() -> None:
    # Two fall at a time, at the speed of the last, and all that fell before lie on each other.
    looks = [heap(500, 0.0) | {str(number): 0.3, str(number + 1): 0.3} for number in range(499)]
    assert seen(*looks).matters(HIT, list(looks[-1]))


def test_what_is_done_to_a_crowd_at_rest_has_nothing_to_do_with_its_fall() -> None:
    rests = seen(heap(500, 3.0), heap(500, 0.0))
    assert not rests.matters(HIT, list(heap(500, 0.0)))
    rests.reset()
    assert rests.matters(HIT, list(heap(500, 0.0)))


def test_two_crowds_that_meet_have_had_what_both_had() -> None:
    # (0.3 m/s)^2 is 2.8 % of 500 (0.08 m/s)^2, and 0.002 % of that and 500 (3 m/s)^2.
    slow, fast = seen(heap(500, 0.08), heap(500, 0.0)), seen(heap(500, 3.0), heap(500, 0.0))
    assert slow.matters(HIT, list(heap(500, 0.0)))
    slow.absorb(fast)
    assert not slow.matters(HIT, list(heap(500, 0.0)))


@pytest.mark.parametrize(("crowd", "eased"), [(5, 1), (4, 0)])
def test_a_run_knows_what_a_crowd_has_had(monkeypatch: pytest.MonkeyPatch, crowd: int, eased: int) -> None:
    # Five planks slide side by side at 3 m/s, and stop after v^2 / (2 mu g) = 0.917 m. The last hits one that stands in
    # its way at (9 - 9.81 * 0.892)^(1/2) = 0.5 m/s: with a fifth of the energy that there is, and 1/180 of what was.
    times: list[float] = []

    def substep_next_contact(world: RestingWorld) -> None:
        times.append(world.time())
        world.engine.ready().substep_next_contact()

    monkeypatch.setattr(room, "CROWD", crowd)
    monkeypatch.setattr(RestingWorld, "substep_next_contact", substep_next_contact)
    sliding = [let_go(str(row), (0.0, 0.2 * row, 0.0039), turned=FLAT, velocity_W=(3.0, 0.0, 0.0)) for row in range(5)]
    stands = set_down("stands", (0.892 + 0.1176, 0.0, 0.0039))
    trace = play(over([stands, *sliding], hold=1.0), SYSTEMS["exact"])
    assert trace.tracks["stands"].shift > 1e-3
    assert len(times) == eased
