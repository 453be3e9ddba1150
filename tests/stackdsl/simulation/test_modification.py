"""A system can play a scene with modified constants, and reports that."""

from dataclasses import replace
from math import cos, radians, sin, sqrt, tan

import pytest

from stability.engines.scene_scale import SceneScale
from stackdsl.checking.results import judged
from stackdsl.judging.judge import with_numerical_collapse
from stackdsl.judging.proofs import DISPROVED
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import AS_WRITTEN, SYSTEMS, Modification, System, as_played
from stackdsl.simulation.worlds import opened_world
from stackdsl.trace import RunVerdict
from tests.scenes import compiled, scene, timeline_of

STOCK = SYSTEMS["stock"]
SIDE = 0.0078  # [m]
IN_THE_AIR = "- bricks: [{name: a, at: [0 mm, 0 mm, 500 mm], drop: true}]"
COLUMN = "- column: {levels: 4, step: 14.7 mm}"
PLANK = "brick: {size: [117.6 mm, 23.4 mm, 7.8 mm], density: 557 kg/m3}\n"
SLOPE = 40.0  # [deg]
STEEP = f"world: {{tilt: {SLOPE:g} deg}}\nbrick: kapla\nfriction: 0.5\nexpect: [verdict: unstable]\n"
ON_A_SLOPE = "- bricks: [{name: a, at: [0 mm, 0 mm, 3.9 mm]}]"


def changed(**constants: float) -> System:
    return replace(STOCK, name="changed", modification=Modification(**constants))


@pytest.mark.parametrize(
    ("modification", "gravity"),
    [
        (AS_WRITTEN, 9.81),
        (Modification(gravity=1.0), 1.0),
        (Modification(size=10.0), 0.981),  # what is ten times as large falls its own length in sqrt(10) times as long
        (Modification(gravity=2.0, size=4.0), 0.5),
    ],
)
def test_a_brick_falls_by_half_g_t_squared_in_the_lengths_that_it_is_written_in(
    modification: Modification, gravity: float
) -> None:
    system = replace(STOCK, modification=modification)
    timeline = as_played(timeline_of(IN_THE_AIR), modification)
    (placement,) = timeline.placements
    world = opened_world(timeline, system)
    world.add_brick(placement.brick, placement.pose)
    for _ in range(24):
        world.step()
    time, step = world.time(), world.settings.time_step
    height = world.states(["a"])["a"].pose.position_W[2]
    world.close()
    assert time == pytest.approx(0.1)
    assert 0.5 - height == pytest.approx(0.5 * gravity * time * (time + step), rel=0.005)  # with a damping of 4 % / s


def test_what_is_dropped_arrives_later_in_weaker_gravity() -> None:
    drop = "impacts: [{after: built + 1 s, drop: {onto: level 1, height: 50 mm}}]\n"
    written = timeline_of("- column: {levels: 1}", drop)
    (hammer,) = (each for each in as_played(written, Modification(gravity=1.0)).placements if each.hits)
    assert hammer.flight == pytest.approx(sqrt(2.0 * 0.05 / 1.0))


def test_rough_planks_stay_on_a_slope_that_those_of_the_scene_slide_down() -> None:
    assert 0.5 < tan(radians(SLOPE)) < 1.5
    timeline = timeline_of(ON_A_SLOPE, STEEP)
    slides, holds = play(timeline, STOCK), play(timeline, changed(friction=1.5))
    assert (slides.verdict, holds.verdict) == (RunVerdict.COLLAPSES, RunVerdict.STANDS)


def test_a_plank_slides_on_a_slope_as_slowly_as_weak_gravity_lets_it() -> None:
    slope = radians(SLOPE)
    fell = play(timeline_of(ON_A_SLOPE, STEEP), changed(gravity=1.0)).collapse
    assert fell is not None
    assert fell.time == pytest.approx(sqrt(SIDE / (sin(slope) - 0.5 * cos(slope))), abs=0.03)


def test_planks_that_are_told_of_as_they_are_written_are_those_of_a_scene_that_is_written_larger() -> None:
    resting = "expect: [{stands: {for: 1 s}}]\n"
    resized = play(timeline_of(COLUMN, f"{PLANK}friction: 0.5\n{resting}"), changed(size=10.0))
    large = "brick: {size: [1176 mm, 234 mm, 78 mm], density: 557 kg/m3}\nfriction: 0.5\n"
    written = play(timeline_of(COLUMN.replace("14.7", "147"), large + resting), STOCK)
    # Creep hangs on the last digits: 1e-15 m aside, and the larger scene creeps by 0.8 mm in place of 0.5.
    assert resized.drift == pytest.approx(written.drift / 10.0, abs=5e-5)
    assert play(timeline_of(COLUMN, f"{PLANK}friction: 0.5\n{resting}"), STOCK).drift > 3.0 * resized.drift
    top = [trace.tracks["L4.1"].final.position_W for trace in (resized, written)]
    assert [10.0 * part for part in top[0]] == pytest.approx(top[1], abs=1e-3)


def test_an_impulse_gives_a_larger_brick_the_speed_that_it_would_give_the_one_that_is_written() -> None:
    system = changed(size=10.0)
    timeline = as_played(timeline_of(IN_THE_AIR), system.modification)
    (placement,) = timeline.placements
    world = opened_world(timeline, system)
    world.add_brick(placement.brick, placement.pose)
    world.push("a", (0.01, 0.0, 0.0), placement.pose.position_W)
    speed = world.states(["a"])["a"].velocity_W[0]
    mass = world.masses()["a"]
    world.close()
    assert speed == pytest.approx(0.01 / mass)
    assert mass == placement.brick.mass


def test_the_force_between_a_larger_brick_and_the_ground_is_its_weight_as_it_is_written() -> None:
    system = changed(size=10.0)
    timeline = as_played(timeline_of(ON_A_SLOPE), system.modification)
    (placement,) = timeline.placements
    world = opened_world(timeline, system)
    world.add_brick(placement.brick, placement.pose)
    for _ in range(240):
        world.step()
    points = world.contacts("a")
    world.close()
    assert sum(point.normal_force for point in points) == pytest.approx(placement.brick.mass * 0.981, rel=0.02)
    assert [point.position_W[2] for point in points] == pytest.approx([0.0] * len(points), abs=1e-4)


def test_a_scene_that_is_larger_in_gravity_that_is_stronger_by_as_much_takes_as_long() -> None:
    (placement,) = timeline_of(ON_A_SLOPE).placements
    usual = SceneScale.of([placement.brick], 0.981)
    assert usual.resized(10.0).gravity == pytest.approx(9.81)
    assert usual.resized(10.0).slower == pytest.approx(usual.slower)


def test_a_collapse_is_held_against_statics_of_the_scene_as_it_is_played() -> None:
    timeline, rough = timeline_of(ON_A_SLOPE, STEEP), changed(friction=1.5)
    slides = play(timeline, STOCK)
    assert with_numerical_collapse(slides, timeline, STOCK).numerical == ""  # it must slide with 0.5
    assert with_numerical_collapse(slides, timeline, rough).numerical == DISPROVED  # and must not with 1.5


def test_a_result_says_with_which_constants_it_was_played() -> None:
    (case,), _ = compiled(scene(ON_A_SLOPE, "systems: [modified]\nexpect: [stands: all]\n"))
    trace = play(case.timeline, SYSTEMS["modified"])
    assert judged(case, trace).modified == "gravity 1 m/s2, friction 1.5 everywhere"
    assert judged(replace(case, system="stock"), trace).modified == ""


def test_a_modification_is_told_in_words() -> None:
    assert AS_WRITTEN.summary == ""
    assert Modification(size=10.0).summary == "lengths times 10"
