"""From scenario to timeline: times, names, levels and places of what is built."""

from math import cos, radians, sin

import pytest

from stability.geometry.vectors import multiply
from stackdsl.timeline import Timeline
from tests.scenes import compiled, mistakes_of, scene, timeline_of

THICKNESS = 0.0078  # of a KAPLA plank [m]


def names(timeline: Timeline) -> list[str]:
    return [placement.brick.id for placement in timeline.placements]


def times(timeline: Timeline) -> list[float]:
    return [placement.time for placement in timeline.placements]


def test_bricks_are_placed_one_each_interval_and_named_by_level_and_order() -> None:
    timeline = timeline_of("- four_stack: {levels: 2}\n  every: 1 s")
    assert names(timeline) == ["L1.1", "L1.2", "L2.1", "L2.2"]
    assert times(timeline) == [0.0, 1.0, 2.0, 3.0]
    assert [placement.level for placement in timeline.placements] == [1, 1, 2, 2]


def test_bricks_that_are_left_out_are_counted_in_the_names_of_the_others() -> None:
    wall = timeline_of("- wall: {levels: 2, bricks: 3, omit: [L1.2, L2.1]}")
    assert names(wall) == ["L1.1", "L1.3", "L2.2", "L2.3", "L2.4"]


def test_without_an_interval_a_step_is_placed_at_one_time() -> None:
    assert times(timeline_of("- column: {levels: 3}")) == [0.0, 0.0, 0.0]


def test_a_step_follows_the_one_before_it_at_that_ones_interval() -> None:
    timeline = timeline_of(
        """
        - column: {levels: 2}
          every: 2 s
        - column: {levels: 2, origin: [0 mm, 100 mm, 0 mm]}
          every: 1 s
        """
    )
    assert times(timeline) == [0.0, 2.0, 4.0, 5.0]


@pytest.mark.parametrize(
    ("when", "start"),
    [
        ("at: 0.5 s", 0.5),
        ("after: start + 7 s", 7.0),
        ("after: built", 2.0),
        ("after: built + 1.5 s", 3.5),
        ("after: level 2", 1.0),
        ("after: brick L3.1 + 0.25 s", 2.25),
    ],
)
def test_a_step_begins_at_its_time_or_when_its_event_is_over(when: str, start: float) -> None:
    timeline = timeline_of(
        f"""
        - column: {{levels: 3}}
          every: 1 s
        - column: {{levels: 1, origin: [0 mm, 100 mm, 0 mm]}}
          {when}
        """
    )
    beside = next(placement for placement in timeline.placements if placement.brick.id == "L1.2")
    assert beside.time == start


def test_a_step_follows_all_of_those_before_it_not_just_the_last_written() -> None:
    timeline = timeline_of(
        """
        - column: {levels: 3}
          every: 4 s
        - column: {levels: 2, origin: [0 mm, 100 mm, 0 mm]}
          every: 1 s
          at: 1 s
        - column: {levels: 1, origin: [0 mm, 200 mm, 0 mm]}
        """
    )
    assert times(timeline) == [0.0, 1.0, 2.0, 4.0, 8.0, 9.0]


def test_placements_are_in_order_of_time_and_then_of_the_file() -> None:
    timeline = timeline_of(
        """
        - column: {levels: 2}
          every: 2 s
        - column: {levels: 2, origin: [0 mm, 100 mm, 0 mm]}
          every: 1 s
          at: 0 s
        """
    )
    assert times(timeline) == [0.0, 0.0, 1.0, 2.0]
    assert names(timeline) == ["L1.1", "L1.2", "L2.2", "L2.1"]


def test_the_level_of_a_single_brick_is_one_above_what_it_stands_on() -> None:
    timeline = timeline_of(
        """
        - bricks:
            - {at: [0 mm, 0 mm, 3.9 mm]}
            - {name: keystone, at: [0 mm, 0 mm, 19.5 mm]}
            - {at: [0 mm, 0 mm, 11.7 mm]}
        """
    )
    assert [(p.brick.id, p.level) for p in timeline.placements] == [("L1.1", 1), ("keystone", 3), ("L2.1", 2)]


def test_a_step_with_a_name_puts_it_before_the_names_of_its_bricks() -> None:
    timeline = timeline_of("- column: {levels: 1}\n  name: tower")
    assert names(timeline) == ["tower.L1.1"]


def test_a_heading_turns_a_layout_and_its_bricks() -> None:
    placement = timeline_of("- column: {levels: 2, step: 10 mm, heading: 90 deg}").placements[1]
    assert placement.pose.position_W == pytest.approx((0.0, 0.01, 1.5 * THICKNESS))
    assert placement.pose.orientation == pytest.approx((0.0, 0.0, sin(radians(45)), cos(radians(45))))


def test_a_tilt_turns_ground_and_bricks_together_so_that_downhill_is_where_it_says() -> None:
    rest = "world: {tilt: {angle: 10 deg, towards: 90 deg}}"
    timeline = timeline_of("- bricks: [{at: [0 mm, 0 mm, 3.9 mm]}]", rest)
    normal = timeline.world.planes[0].normal_W
    assert normal == pytest.approx((0.0, sin(radians(10)), cos(radians(10))))
    assert timeline.placements[0].pose.position_W == pytest.approx([0.0039 * part for part in normal])


def test_a_wall_stands_at_its_bearing_and_faces_the_origin() -> None:
    rest = "friction: 0.4\nworld: {walls: [{bearing: 90 deg, distance: 0.2 m, friction: 0}]}"
    ground, wall = timeline_of("- column: {levels: 1}", rest).world.planes
    assert (ground.id, ground.friction) == ("ground", 0.4)
    assert wall.point_W == pytest.approx((0.0, 0.2, 0.0))
    assert wall.normal_W == pytest.approx((0.0, -1.0, 0.0))
    assert wall.friction == 0.0


def test_mass_is_density_times_volume_and_half_planks_weigh_half() -> None:
    masses = {p.brick.id: p.brick.mass for p in timeline_of("- wall: {levels: 2, bricks: 2, gap: 0 mm}").placements}
    assert masses["L1.1"] == pytest.approx(557.0 * 0.1176 * 0.0234 * 0.0078)
    assert masses["L2.1"] == pytest.approx(masses["L1.1"] / 2.0)


def test_the_structure_is_watched_as_long_as_an_expectation_asks() -> None:
    assert timeline_of("- column: {levels: 1}", "expect: [{stands: {for: 5 s}}]").end == 5.0


def test_every_variant_of_a_matrix_is_compiled_for_every_system() -> None:
    text = scene(
        '- column: {levels: 4, step: "${step}"}',
        "matrix: {step: [1 mm, 2 mm]}\nsystems: [thesis, stock]",
    )
    cases, _ = compiled(text)
    assert [case.identity.variant for case in cases] == [
        "step=1mm,thesis",
        "step=1mm,stock",
        "step=2mm,thesis",
        "step=2mm,stock",
    ]


LOW, HIGH = "{name: low, at: [0 mm, 0 mm, 3.9 mm]}", "{name: high, at: [0 mm, 0 mm, 11.7 mm], level: LEVEL}"


@pytest.mark.parametrize("level", [1, 2])
def test_an_authors_level_may_be_up_to_one_above_what_the_brick_stands_on(level: int) -> None:
    timeline = timeline_of(f"- bricks: [{LOW}, {HIGH.replace('LEVEL', str(level))}]")
    assert [placement.level for placement in timeline.placements] == [1, level]


@pytest.mark.parametrize(
    ("bricks", "words"),
    [
        ("{name: low, at: [0 mm, 0 mm, 3.9 mm], level: 7}", "'low' stands on the ground, so its level cannot be 7"),
        ("{name: low, at: [0 mm, 0 mm, 3.9 mm], level: 7, drop: true}", "'low' stands on the ground"),
        (f"{LOW}, {HIGH.replace('LEVEL', '3')}", "'high' stands on level 1, so its level cannot be 3"),
        (f"{HIGH.replace('LEVEL', '3')}, {LOW}", "'high' stands on level 1"),
        # Only the first is wrong: a brick on it is at most one above what the author said of it.
        (f"{LOW.replace('}', ', level: 2}')}, {HIGH.replace('LEVEL', '3')}", "'low' stands on the ground"),
    ],
)
def test_an_authors_level_does_not_leave_levels_out(bricks: str, words: str) -> None:
    (mistake,) = mistakes_of(f"- bricks: [{bricks}]", "expect: [{stands: {levels: 3}}]")
    assert mistake.code == "SD104"
    assert words in mistake.message
    excerpt = mistake.span.excerpt[mistake.span.column - 1 : mistake.span.end_column - 1]
    assert f"cannot be {excerpt}" in mistake.message
    assert "remove `level`" in mistake.hint


def test_a_brick_on_a_layout_goes_by_the_levels_of_the_layout() -> None:
    build = "- column: {levels: 3}\n- bricks: [{name: top, at: [0 mm, 0 mm, 27.3 mm], level: LEVEL}]"
    assert mistakes_of(build.replace("LEVEL", "4")) == []
    assert "stands on level 3" in mistakes_of(build.replace("LEVEL", "5"))[0].message


def test_the_level_of_a_brick_let_go_in_the_air_is_its_authors_affair() -> None:
    bricks = "{at: [0 mm, 0 mm, 50 mm], drop: true, level: 7}, {at: [0 mm, 40 mm, 50 mm], drop: true}"
    assert [placement.level for placement in timeline_of(f"- bricks: [{bricks}]").placements] == [7, 1]


def test_a_brick_may_be_dropped_from_the_air() -> None:
    assert mistakes_of("- bricks: [{at: [0 mm, 0 mm, 50 mm], drop: true}]") == []


def test_compiling_twice_gives_the_same_timeline() -> None:
    text = scene("- wall: {levels: 6, bricks: 4}\n  every: 0.1 s")
    assert compiled(text)[0][0].timeline == compiled(text)[0][0].timeline


# --- layouts set down in pairs, or until they fall --------------------------------------------------------------------


def test_the_two_planks_of_a_v_are_set_down_at_one_moment() -> None:
    #  levels 1 and 3 are of Vs, level 2 of the flat plank between them
    timeline = timeline_of("- card_house: {levels: 2}\n  every: 1 s\n- column: {levels: 1, origin: [1 m, 0 m, 0 m]}")
    placed = list(zip(names(timeline), times(timeline), strict=True))[:-1]
    assert placed == [
        ("L1.1", 0.0), ("L1.2", 0.0), ("L1.3", 1.0), ("L1.4", 1.0), ("L2.1", 2.0), ("L3.1", 3.0), ("L3.2", 3.0),
    ]  # fmt: skip
    assert times(timeline)[-1] == 4.0


def test_a_card_house_turns_about_its_origin_with_its_heading() -> None:
    house = "- card_house: {levels: 2, heading: HEADING, origin: [1 m, 2 m, 0 m]}"
    one, other = (timeline_of(house.replace("HEADING", heading)).placements for heading in ("0 deg", "90 deg"))
    quarter = (0.0, 0.0, sin(radians(45)), cos(radians(45)))
    for a, b in zip(one, other, strict=True):
        (x, y, z), turn = a.pose.position_W, multiply(quarter, a.pose.orientation)
        assert b.pose.position_W == pytest.approx((1.0 - (y - 2.0), 2.0 + (x - 1.0), z), abs=1e-12)
        assert b.pose.orientation == pytest.approx(turn, abs=1e-12)


def test_a_step_until_a_collapse_goes_on_for_a_hundred_levels() -> None:
    timeline = timeline_of("- four_stack: {step: 1 mm}\n  every: 1 s\n  until: collapse")
    assert (timeline.levels, len(timeline.placements), timeline.built) == (100, 200, 199.0)
    assert timeline_of("- column: {levels: 7}\n  every: 1 s\n  until: collapse").levels == 7
