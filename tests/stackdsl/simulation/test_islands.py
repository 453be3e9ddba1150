"""Distant bricks are played as separate islands, which merge with their full state when they approach."""

from collections.abc import Mapping

import pytest

from stability.engines.lazy_world import NearEngine
from stability.model import BodyId, BodyState, Vec3
from stackdsl.simulation import islands
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.islands import MOST, Island, far_apart
from stackdsl.simulation.recording import Recorder
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.timeline import Arrival, HoldAction, Placement, PushAction, Removal, Timeline
from tests.stackdsl.simulation.let_go import CUBE, FLAT, GRAVITY, let_go, over, set_down

EXACT = SYSTEMS["exact"]


def names(timeline: Timeline) -> list[list[str]]:
    return [[placement.brick.id for placement in part] for part in far_apart(timeline)]


# --- who is far apart -------------------------------------------------------------------------------------------------


def test_what_may_topple_onto_each_other_is_one_part_and_what_is_farther_is_two() -> None:
    high = 1.0  # each may come so far, and rolls on by some lengths
    for apart, count in ((0.5 * high, 1), (2.0 * high, 1), (4.0 * high, 2)):
        towers = [let_go("a", (0.0, 0.0, high)), let_go("b", (0.0, apart, high))]
        assert len(names(over(towers))) == count


def test_what_is_aimed_at_a_brick_is_of_its_part_however_far_it_flies() -> None:
    flying = let_go("flying", (-20.0, 0.0, 0.1), velocity_W=(20.0, 0.0, 4.9), flight=1.0)
    assert names(over([let_go("aim", (0.0, 0.0, 0.1)), flying])) == [["aim", "flying"]]


def test_parts_stand_in_rows_and_columns() -> None:
    grid = [let_go(f"{x}{y}", (5.0 * x, 5.0 * y, 0.1)) for x in range(2) for y in range(3)]
    assert names(over(grid)) == [["00"], ["01"], ["02"], ["10"], ["11"], ["12"]]


def test_beyond_so_many_the_last_part_has_all_that_is_left() -> None:
    found = names(over([let_go(f"{n}", (5.0 * n, 0.0, 0.1)) for n in range(MOST + 3)]))
    assert [len(part) for part in found] == [1] * (MOST - 1) + [4]


def test_as_many_as_there_may_be_are_each_by_itself() -> None:
    assert [len(part) for part in names(over([let_go(f"{n}", (5.0 * n, 0.0, 0.1)) for n in range(MOST)]))] == [1] * MOST


def test_hands_have_all_in_one_part() -> None:
    assert len(names(over([let_go("a", (0.0, 0.0, 0.1)), let_go("b", (9.0, 0.0, 0.1)), HoldAction(1.0, ("a",))]))) == 1


# --- who meets --------------------------------------------------------------------------------------------------------


class Seen(Recorder):
    """Who was where last, until a time."""

    def __init__(self, until: float) -> None:
        super().__init__()
        self.until, self.time, self.last = until, 0.0, dict[BodyId, BodyState]()

    def see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        if time <= self.until:
            self.time = time
            self.last |= states
        super().see(time, states)


def momentum(bricks: list[Placement], states: dict[BodyId, BodyState] | None = None) -> Vec3:
    velocities = {
        each.brick.id: states[each.brick.id].velocity_W if states is not None else each.velocity_W for each in bricks
    }
    x, y, z = (sum(each.brick.mass * velocities[each.brick.id][axis] for each in bricks) for axis in range(3))
    return x, y, z


def test_two_that_fly_towards_one_another_meet_and_keep_their_momentum() -> None:
    #   As they do not bounce, both go on with the mean speed, and turn about each other.
    cubes = [
        let_go("a", (-2.0, 0.0, 1.0), CUBE, FLAT, (10.0, 0.0, 0.0)),
        let_go("b", (2.0, 0.02, 1.0), CUBE, FLAT, (-7.0, 0.0, 0.0)),
    ]
    recorder = Seen(until=0.3)  # they meet at 0.23 s, and would land at 0.44 s
    assert len(names(over(cubes))) == 2
    trace = play(over(cubes, hold=0.32), EXACT, recorder=recorder)
    before, after = momentum(cubes), momentum(cubes, recorder.last)
    assert after[:2] == pytest.approx(before[:2], abs=1e-9)
    assert recorder.last["a"].velocity_W[0] == pytest.approx(1.5, abs=0.3)
    falls = GRAVITY * recorder.time * sum(each.brick.mass for each in cubes)
    assert after[2] == pytest.approx(-falls, rel=0.01)
    assert trace.energy is not None
    assert trace.energy.gain < 1e-3


def test_two_that_pass_each_other_are_one_part_and_fall_on_as_before(met: list[str]) -> None:
    #   One drops straight, of which no engine is told; the other flies by, 0.2 m beside it.
    drops = let_go("drops", (0.0, 0.0, 1.2), CUBE, FLAT, time=0.003)
    flies = let_go("flies", (3.6, 0.2, 1.1), CUBE, FLAT, (-10.0, 0.0, 0.0))
    recorder = Seen(until=0.42)
    trace = play(over([drops, flies], hold=0.44), EXACT, recorder=recorder)
    assert met == ["flies meets drops"]
    for each in (drops, flies):
        height = each.pose.position_W[2] - 0.5 * GRAVITY * (recorder.time - each.time) ** 2
        assert recorder.last[each.brick.id].pose.position_W[2] == pytest.approx(height, abs=2e-3)
    assert trace.cost.judgements >= trace.cost.steps  # one after each, of either part


TOWER = [set_down(f"tower {n}", (0.0, 0.0, 0.05 + 0.1 * n), CUBE) for n in range(3)]


def shot() -> Placement:
    """At the top of the tower, which it is not known to be aimed at."""
    flight = (3.0 - 0.1) / 8.0
    velocity_W = (8.0, 0.0, 0.5 * GRAVITY * flight)
    return let_go("shot", (-3.0, 0.0, 0.25), CUBE, FLAT, velocity_W, time=0.1, arrival=Arrival.THROWN)


# It slides by v^2 / (2 mu g) = 1.6 m.
SLIDING = let_go("sliding", (-2.0, 0.3, 0.05), CUBE, FLAT, (4.0, 0.0, 0.0))


def test_what_flies_far_meets_what_stands_there_as_if_it_had_always_been_near(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = over([*TOWER, shot()], hold=0.7)
    assert len(names(scene)) == 2
    apart = play(scene, EXACT)
    monkeypatch.setattr(islands, "far_apart", lambda timeline: [list(timeline.placements)])
    together = play(scene, EXACT)
    for trace in (apart, together):
        assert trace.collapse is not None
        assert trace.energy is not None
        assert trace.energy.gain < 1e-3
    assert {name: track.state for name, track in apart.tracks.items()} == {
        name: track.state for name, track in together.tracks.items()
    }
    assert apart.collapse is not None
    assert together.collapse is not None
    assert apart.collapse.time == pytest.approx(together.collapse.time, abs=0.011)  # a look
    assert [event.time for event in apart.events] == sorted(event.time for event in apart.events)


def test_what_stood_alone_stands_on_beside_what_has_come_near_and_is_pushed_as_before(met: list[str]) -> None:
    #   J = 2 N s at 40 mm above the centre of 0.6 kg throws the uppermost off the second.
    push = PushAction(1.2, "tower 2", (2.0, 0.0, 0.0), (0.0, 0.0, 0.04))
    trace = play(over([*TOWER, SLIDING, push], hold=0.5), EXACT)
    assert met == ["sliding meets tower 0"]
    assert trace.tracks["sliding"].final.position_W[0] == pytest.approx(-0.37, abs=0.02)
    woken = [event for event in trace.events if event.kind == "woken"]
    assert woken[0].time == pytest.approx(1.2)
    assert trace.tracks["tower 0"].frozen
    assert trace.tracks["tower 2"].shift > 0.1


# --- what is told of all ----------------------------------------------------------------------------------------------


def test_an_engine_is_closed_when_all_bricks_are_at_rest_for_good(monkeypatch: pytest.MonkeyPatch) -> None:
    given_back: dict[str, float] = {}
    close_engine = NearEngine.close_engine

    def noted(engine: NearEngine) -> None:
        for name in engine.stored.own.bricks:
            given_back.setdefault(name, engine.clock if engine.world is None else engine.world.time())
        close_engine(engine)
        assert engine.world is None

    monkeypatch.setattr(NearEngine, "close_engine", noted)
    falling = [
        let_go("a", (0.0, 0.0, 0.06)),
        let_go("b", (10.0, 0.0, 0.4)),
        let_go("late", (10.0, 1.0, 0.06), time=0.4),
    ]
    trace = play(over(falling, hold=0.4), EXACT)
    assert given_back["a"] < 0.3
    assert given_back["b"] > 0.4
    assert all(track.frozen for track in trace.tracks.values())


def test_what_happens_in_two_parts_is_told_in_the_order_of_time() -> None:
    #   The first lands after sqrt(2 h / g) = 98 ms, of which it is known ten time steps ahead.
    flat = [let_go("first", (0.0, 0.0, 0.05), turned=FLAT), let_go("second", (9.0, 0.0, 0.05), time=0.096, turned=FLAT)]
    events = play(over(flat, hold=0.2), EXACT).events
    assert [event.bricks for event in events] == [("first",), ("second",), ("first",), ("second",)]
    assert [event.time for event in events] == pytest.approx([0.0, 0.096, 0.098, 0.194], abs=1.1e-3)


def test_bricks_are_taken_out_of_two_parts_at_once() -> None:
    there = [set_down(f"there {n}", (9.0, 0.0, 0.05 + 0.1 * n), CUBE) for n in range(2)]
    trace = play(over([*TOWER, *there, Removal(0.5, ("tower 0", "there 0"))], hold=0.5), EXACT)
    assert [event.bricks for event in trace.events if event.kind == "removed"] == [("tower 0", "there 0")]
    assert {trace.tracks[name].state for name in ("tower 1", "tower 2", "there 1")} == {"fallen"}
    assert trace.tracks["there 1"].final.position_W[2] == pytest.approx(0.05, abs=1e-4)


def test_what_is_proven_in_a_part_that_meets_another_at_once_is_told_once(met: list[str]) -> None:
    #   More than half of the plank on top hangs over. Beside it two cubes are thrown at each other, far from a tower.
    planks = [set_down("foot", (9.0, 0.0, 0.0039)), set_down("top", (9.07, 0.0, 0.0117))]
    west = let_go("west", (9.0, 0.4, 0.2), CUBE, FLAT, (30.0, 0.0, 0.0))
    east = let_go("east", (11.0, 0.4, 0.2), CUBE, FLAT, (-30.0, 0.0, 0.0))
    trace = play(over([*TOWER, *planks, west, east], hold=0.01), EXACT)
    assert met == ["foot meets east"]
    assert trace.statics is not None
    assert trace.statics.moving == ("top",)


def test_what_stands_in_two_parts_carries_as_it_does_in_one() -> None:
    there = [set_down(f"there {n}", (9.0, 0.0, 0.05 + 0.1 * n), CUBE) for n in range(2)]
    trace = play(over([*TOWER, *there], hold=0.1), EXACT)
    carried = {(edge.upper, edge.lower): edge.share for edge in trace.edges}
    assert carried["tower 2", "tower 1"] == carried["there 1", "there 0"] == 1.0
    assert trace.statics is not None
    assert trace.statics.stability == "stable"
    assert trace.cost.steps == 0


def test_a_brick_that_comes_where_one_of_another_part_has_got_to_needs_room_and_may_stand_on_it() -> None:
    at_W = play(over([SLIDING], hold=1.0), EXACT).tracks["sliding"].final.position_W
    blocked, on = (set_down("late", (*at_W[:2], at_W[2] + up), CUBE, time=1.0) for up in (0.0, 0.1))
    assert len(names(over([SLIDING, on]))) == 2
    with pytest.raises(BlockedPlacementError):
        play(over([SLIDING, blocked], hold=0.1), EXACT)
    trace = play(over([SLIDING, on], hold=0.1), EXACT)
    assert trace.tracks["late"].frozen
    assert trace.collapse is None
    assert [edge.lower for edge in trace.edges if edge.upper == "late"] == ["sliding"]


@pytest.fixture
def met(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Which parts met, each by its first brick."""
    told: list[str] = []
    absorb = Island.absorb

    def noted(part: Island, other: Island) -> None:
        told.append(f"{next(iter(part.world.masses()))} meets {next(iter(other.world.masses()))}")
        absorb(part, other)

    monkeypatch.setattr(Island, "absorb", noted)
    return told
