"""When hands come, move, hold and let go, and what cannot be asked of them."""

from itertools import pairwise

import pytest

from stackdsl.compiler import hands
from stackdsl.timeline import Action, Arrival, HoldAction, MoveAction, Placement, ReleaseAction, Timeline
from tests.scenes import mistakes_of, timeline_of

LOWERED = 15.0 / 8.0 * 0.02 / 0.05  # [s] 20 mm at up to 50 mm/s
COLUMN = "- column: {levels: 3}"


def of_kind(timeline: Timeline, kind: type[Action]) -> list[Action]:
    return [action for action in timeline.actions if isinstance(action, kind)]


def begun(timeline: Timeline) -> dict[str, float]:
    """When each brick comes [s]."""
    return {placement.brick.id: placement.time for placement in timeline.placements}


def let_go(timeline: Timeline) -> dict[str, float]:
    """When each brick is let go [s]."""
    return {
        name: action.time for action in timeline.actions if isinstance(action, ReleaseAction) for name in action.bricks
    }


# --- what is brought --------------------------------------------------------------------------------------------------


def test_a_hand_brings_one_brick_after_another_each_from_above_its_place() -> None:
    timeline = timeline_of(f"{COLUMN}\n  place: by hand")
    for number, placement in enumerate(timeline.placements):
        assert placement.arrival is Arrival.BY_HAND
        assert placement.time == pytest.approx(number * LOWERED)
        assert placement.came is not None
        assert placement.came.position_W[2] - placement.pose.position_W[2] == pytest.approx(0.02)
    assert list(let_go(timeline).values()) == pytest.approx([LOWERED, 2 * LOWERED, 3 * LOWERED])
    assert timeline.end == pytest.approx(3 * LOWERED + timeline.hold)
    assert not of_kind(timeline, HoldAction)


def test_the_next_one_comes_at_the_very_moment_at_which_the_one_before_is_let_go() -> None:
    timeline = timeline_of("- column: {levels: 40}\n  place: by hand")
    ends, begins = list(let_go(timeline).values()), list(begun(timeline).values())
    assert ends[:-1] == begins[1:]  # to the last digit
    assert all(before.time <= after.time for before, after in pairwise(timeline.actions))


def test_every_counts_from_when_a_brick_is_let_go() -> None:
    timeline = timeline_of(f"{COLUMN}\n  place: {{held: 0.5 s}}\n  every: 1 s")
    period = LOWERED + 0.5 + 1.0
    assert list(begun(timeline).values()) == pytest.approx([0.0, period, 2 * period])
    assert [action.time for action in of_kind(timeline, HoldAction)] == pytest.approx(
        [LOWERED + number * period for number in range(3)]
    )


@pytest.mark.parametrize(
    ("when", "time"),
    [
        ("after: brick L1.1", LOWERED + 0.5),
        ("after: level 2 + 0.1 s", 2 * (LOWERED + 0.5) + 0.1),
        ("after: built", 3 * (LOWERED + 0.5)),
        ("", 3 * (LOWERED + 0.5)),
    ],
)
def test_anchors_and_what_comes_next_wait_until_hands_let_go(when: str, time: float) -> None:
    step = f"- {{{when + ', ' if when else ''}bricks: [{{name: last, at: [300 mm, 0 mm, 3.9 mm]}}]}}"
    timeline = timeline_of(f"{COLUMN}\n  place: {{held: 0.5 s}}\n{step}")
    assert begun(timeline)["last"] == pytest.approx(time)


def test_bricks_that_come_together_are_let_go_together() -> None:
    timeline = timeline_of("- card_house: {levels: 2, angle: 70 deg}\n  place: {from: [0 mm, 0 mm, 60 mm]}")
    together = [action.bricks for action in of_kind(timeline, ReleaseAction) if isinstance(action, ReleaseAction)]
    assert max(map(len, together)) >= 2


def test_a_tilted_scene_tilts_the_way_of_a_hand() -> None:
    timeline = timeline_of(f"{COLUMN}\n  place: by hand", "world: {tilt: {angle: 10 deg, towards: 30 deg}}")
    (move, *_) = (action for action in timeline.actions if isinstance(action, MoveAction))
    first = timeline.placements[0]
    assert first.came is not None
    arrived = tuple(a + b for a, b in zip(first.came.position_W, move.course.end_W, strict=True))
    assert arrived == pytest.approx(first.pose.position_W)
    assert move.lowers


def test_for_statics_what_hands_bring_is_set_down_when_it_is_let_go() -> None:
    settled = timeline_of(f"{COLUMN}\n  place: by hand").as_set_down()
    assert all(isinstance(action, Placement) and action.arrival is Arrival.SET_DOWN for action in settled.actions)
    assert [action.time for action in settled.actions] == pytest.approx([LOWERED, 2 * LOWERED, 3 * LOWERED])
    held = timeline_of(f"{COLUMN}\n  place: {{held: 1 s}}").as_set_down()
    assert of_kind(held, HoldAction)  # a proof for it would have to know of hands


# --- what is moved and held -------------------------------------------------------------------------------------------


def test_a_move_is_over_when_the_brick_is_let_go_and_what_follows_waits() -> None:
    impacts = """impacts:
    - at: 1 s
      move: {brick: L3.1, by: [30 mm, 40 mm, 0 mm], held: 0.3 s}
    - after: impact 1 + 0.2 s
      hold: {brick: L2.1, for: 0.4 s}
    - push: {brick: L3.1, impulse: [1 mN*s, 0 N*s, 0 N*s]}"""
    timeline = timeline_of(COLUMN, impacts)
    way = 15.0 / 8.0 * 0.05 / 0.05
    times = [(type(action).__name__, action.time) for action in timeline.actions[3:]]
    assert [name for name, _ in times] == [
        "MoveAction",
        "HoldAction",
        "ReleaseAction",
        "HoldAction",
        "ReleaseAction",
        "PushAction",
    ]
    ends = [1.0, 1.0 + way, 1.3 + way, 1.5 + way, 1.9 + way, 1.9 + way]
    assert [time for _, time in times] == pytest.approx(ends)


def test_moves_of_one_brick_that_follow_on_each_other_do_not_overlap() -> None:
    moves = "\n".join(f"    - move: {{brick: L3.1, by: [{1 + 0.1 * i} mm, 0 mm, 0 mm], held: 0.1 s}}" for i in range(9))
    timeline = timeline_of(COLUMN, f"impacts:\n{moves}")
    kinds = [type(action).__name__ for action in timeline.actions[3:]]
    assert kinds == ["MoveAction", "HoldAction", "ReleaseAction"] * 9


def test_a_slid_brick_is_free_along_the_normal_of_its_ground() -> None:
    scene = "world: {tilt: {angle: 10 deg}}\nimpacts: [move: {brick: L3.1, by: [9 mm, 0 mm, 0 mm], slid: true}]"
    timeline = timeline_of(COLUMN, scene)
    (move,) = (action for action in timeline.actions if isinstance(action, MoveAction))
    assert move.free_W == pytest.approx(timeline.world.planes[0].normal_W)


# --- mistakes ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("impacts", "code", "words"),
    [
        ("move: {brick: L9.1, by: [9 mm, 0 mm, 0 mm]}", "SD204", "no brick 'L9.1'"),
        ("at: 1 s, move: {brick: late, by: [9 mm, 0 mm, 0 mm]}", "SD204", "'late' is not placed before 5 s"),
        ("move: {brick: L3.1}", "SD108", "exactly one of the keys by, path"),
        ("move: {brick: L3.1, by: [0 mm, 0 mm, 0 mm]}", "SD104", "path of the hand is zero"),
        ("move: {brick: L3.1, by: [0 mm, 0 mm, 1e-300 mm]}", "SD104", "path of the hand is zero"),
        ("move: {brick: L3.1, path: [[9 mm, 0 mm, 0 mm], [9 mm, 0 mm, 0 mm]]}", "SD104", "position 2 of the path"),
        ("move: {brick: L3.1, by: [9 mm, 0 mm, 1 mm], slid: true}", "SD104", "needs a horizontal path"),
        ("move: {brick: L3.1, by: [9 mm, 0 mm, 0 mm], speed: 0.5 m/s}", "SD104", "too fast for the thinnest brick"),
        ("move: {brick: L3.1, by: [9 mm, 0 mm, 0 mm], speed: 0 m/s}", "SD104", "not greater than zero"),
        ("move: {brick: L1.1, by: [0 mm, 0 mm, -9 mm]}", "SD209", "9 mm into ground"),
        ("hold: {brick: L1.1, for: 0 s}", "SD104", "not greater than zero"),
        ("hold: {brick: L1.1}", "SD102", "for"),
    ],
)
def test_mistakes_about_moves_are_told(impacts: str, code: str, words: str) -> None:
    build = f"{COLUMN}\n- {{at: 5 s, bricks: [{{name: late, at: [300 mm, 0 mm, 3.9 mm]}}]}}"
    (mistake,) = mistakes_of(build, f"impacts: [{{{impacts}}}]")
    assert mistake.code == code
    assert words in f"{mistake.message} {mistake.hint}"
    assert mistake.hint


@pytest.mark.parametrize(
    "second",
    [
        "move: {brick: L3.1, by: [9 mm, 0 mm, 0 mm]}",
        "hold: {brick: L3.1, for: 1 s}",
        "push: {brick: L3.1, impulse: [1 mN*s, 0 N*s, 0 N*s]}",
        "remove: {brick: L3.1}",
    ],
)
def test_a_brick_is_in_one_hand_at_a_time(second: str) -> None:
    impacts = f"impacts: [hold: {{brick: L3.1, for: 2 s}}, {{at: 1 s, {second}}}]"
    (mistake,) = mistakes_of(COLUMN, impacts)
    assert mistake.code == "SD209"
    assert "the hand of" in mistake.message
    assert "2 s" in mistake.hint


def test_a_brick_is_not_pushed_while_a_hand_holds_it() -> None:
    (mistake,) = mistakes_of(
        f"{COLUMN}\n  place: {{held: 4 s}}",
        "impacts: [{at: 2 s, push: {brick: L1.1, impulse: [1 mN*s, 0 N*s, 0 N*s]}}]",
    )
    assert mistake.code == "SD209"


def test_moves_add_up_until_they_lead_into_a_wall() -> None:
    wall = "world: {walls: [{bearing: 0 deg, distance: 100 mm}]}"
    moves = "impacts: [move: {brick: L3.1, by: [40 mm, 0 mm, 0 mm]}, move: {brick: L3.1, by: [9 mm, 0 mm, 0 mm]}]"
    (mistake,) = mistakes_of(COLUMN, f"{wall}\n{moves}")
    assert mistake.code == "SD209"
    assert "7.8 mm into wall1" in mistake.message


def test_a_hand_does_not_come_through_what_stands() -> None:
    (mistake,) = mistakes_of(
        "- bricks: [{name: a, at: [0 mm, 0 mm, 20 mm], brick: {size: [20 mm, 20 mm, 40 mm], mass: 30 g}},"
        " {name: b, at: [0 mm, 60 mm, 20 mm], brick: {size: [20 mm, 20 mm, 40 mm], mass: 30 g}},"
        " {name: roof, at: [0 mm, 30 mm, 45 mm], brick: {size: [20 mm, 80 mm, 10 mm], mass: 30 g}}]\n"
        "- bricks: [{name: under, at: [0 mm, 30 mm, 5 mm], brick: {size: [10 mm, 10 mm, 10 mm], mass: 3 g}}]\n"
        "  place: {from: [0 mm, 0 mm, 60 mm]}"
    )
    assert mistake.code == "SD209"
    assert "'roof' blocks the path of the hand that brings brick 'under'" in mistake.message


def test_of_a_large_scene_only_what_is_near_its_way_is_held_against_a_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    met = []
    monkeypatch.setattr(hands, "meeting", lambda *bodies: met.append(bodies))
    levels = 100
    assert not mistakes_of(f"- column: {{levels: {levels}}}\n  place: by hand")
    assert 0 < len(met) < 10 * levels


def test_a_brick_may_be_brought_from_the_side() -> None:
    timeline = timeline_of(
        "- bricks: [{at: [0 mm, 0 mm, 3.9 mm]}]\n  place: {from: [200 mm, 0 mm, 0 mm], speed: 0.2 m/s}"
    )
    (placement,) = timeline.placements
    assert placement.came is not None
    assert placement.came.position_W == pytest.approx((0.2, 0.0, 3.9e-3))


def test_a_brick_is_not_brought_out_of_the_ground() -> None:
    (mistake,) = mistakes_of(f"{COLUMN}\n  place: {{from: [0 mm, 0 mm, -20 mm]}}")
    assert mistake.code == "SD209"
    assert "inside ground" in mistake.message


def test_a_brick_is_dropped_or_placed_by_hand_and_not_both() -> None:
    (mistake,) = mistakes_of("- bricks: [{at: [0 mm, 0 mm, 50 mm], drop: true}]\n  place: by hand")
    assert mistake.code == "SD108"


def test_hands_go_on_until_it_collapses_without_being_told_how_often() -> None:
    timeline = timeline_of("- column: {step: 12 mm}\n  place: by hand\n  until: collapse")
    assert len(timeline.placements) == 100


@pytest.mark.parametrize(
    "word", ["by foot", "3", "{}", "{speed: 1 km/h}", "{from: [0 mm, 0 mm, 0 mm]}", "{from: [0 mm, 0 mm, 1e-300 mm]}"]
)
def test_other_words_for_placing_are_refused(word: str) -> None:
    assert mistakes_of(f"{COLUMN}\n  place: {word}")
