"""Collapses played on `exact`: they begin as statics says, last as long as a rigid body's, and gain no energy."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from math import acos, asin, atan, cos, degrees, hypot, sin, sqrt

import pytest

from stability.engines.pybullet import PyBulletWorld
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.box import Box
from stability.geometry.placed_shape import apart
from stability.geometry.vectors import dot, norm, subtract, turn_between
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Motion, Placed, Stability
from stability.stabilizers.known_motion import FallingParts
from stability.statics.assembly import Assembly
from stackdsl.judging.judge import judge
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import MOVING, SYSTEMS
from stackdsl.timeline import Removal
from stackdsl.trace import BrickState, EventKind, RunVerdict, Trace
from tests.scenes import compiled, scene, timeline_of

LENGTH, WIDTH, THICKNESS = 0.1176, 0.0234, 0.0078  # of a KAPLA plank [m]
MASS = 0.012
G = 9.81  # [m/s2]
FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)


ONE_RUN = pytest.mark.xdist_group("towers that fall")  # it takes long


@cache  # a run repeats to the last bit, so one serves all that is asked of it
def collapse(build: str) -> Trace:
    trace = play(replace(timeline_of(f"- {build}\n  every: 1 s"), closely=True), SYSTEMS["exact"])
    assert trace.collapse is not None
    return trace


def turned_about_y(point: Vec3, edge: tuple[float, float], angle: float) -> Vec3:
    x, z = point[0] - edge[0], point[2] - edge[1]
    return (edge[0] + x * cos(angle) + z * sin(angle), point[1], edge[1] + z * cos(angle) - x * sin(angle))


@ONE_RUN
@pytest.mark.parametrize(
    ("build", "level", "edge"),
    [
        # The far upper edge of the leading plank of level 2, at d + (s + w) / 2; see scenarios/slant-tower.yaml.
        ("four_stack: {levels: 7, step: 11.5 mm, spacing: 43 mm}", 7, (0.0447, 2.0 * THICKNESS)),
        # The ends of the planks of level 1.
        pytest.param("four_stack: {levels: 10, step: 11 mm}", 10, (LENGTH / 2.0, THICKNESS), marks=pytest.mark.slow),
        # The same of a tower so tall that a solver lets its foot sink by more than that turns.
        ("column: {levels: 24, step: 5 mm}", 24, (LENGTH / 2.0, THICKNESS)),
    ],
)
def test_a_slanting_tower_begins_to_turn_as_one_body_about_the_edge_that_it_hangs_over(
    build: str, level: int, edge: tuple[float, float]
) -> None:
    trace = collapse(build)
    assert trace.collapse is not None
    assert trace.collapse.level == level
    assert trace.onset is not None
    angle = max(turn_between(*pair) for pair in trace.onset.poses.values())
    furthest = 0.0, 0.0
    seen = []
    for before, after in trace.onset.poses.values():
        expected = subtract(turned_about_y(before.position_W, edge, angle), before.position_W)
        found = subtract(after.position_W, before.position_W)
        off = acos(min(1.0, dot(expected, found) / (norm(expected) * norm(found))))
        assert degrees(off) < 2.0
        furthest = max(furthest, (norm(expected), norm(found)))
        seen.append((norm(expected), norm(found)))
    assert all(found / furthest[1] == pytest.approx(e / furthest[0], abs=0.03) for e, found in seen)


def rigid_time(centres: Sequence[tuple[float, float]], angle: float) -> float:
    """How long planks along x take to turn as one from rest about an edge, from which their centres are given [s]."""
    n = len(centres)
    own = (LENGTH**2 + THICKNESS**2) / 12.0
    inertia = sum(x * x + z * z + own for x, z in centres) / n
    x, z = sum(x for x, _ in centres) / n, sum(z for _, z in centres) / n

    def rate(turn: float) -> float:
        return sqrt(2.0 * G * (x * sin(turn) + z * (1.0 - cos(turn))) / inertia)

    # With turn = u^2 the time, the integral of 1 / rate, has no pole at the beginning.
    parts = 20_000
    step = sqrt(angle) / parts
    return sum(2.0 * u / rate(u * u) * step for u in ((k + 0.5) * step for k in range(parts)))


@ONE_RUN
def test_a_tall_column_falls_in_the_time_of_a_rigid_body_though_it_hangs_over_by_a_millimetre() -> None:
    levels, shift = 24, 0.005
    trace = collapse("column: {levels: 24, step: 5 mm}")
    assert trace.collapse is not None
    centres = [(shift * k - LENGTH / 2.0, THICKNESS * (k - 0.5)) for k in range(1, levels)]
    # The highest plank leaves its place when the chord of its arc is half a plank's thickness.
    angle = 2.0 * asin(0.25 * THICKNESS / hypot(*centres[-1]))
    started = max(event.time for event in trace.events if event.kind is EventKind.PLACED)
    expected = rigid_time(centres, angle)
    assert trace.collapse.time - started == pytest.approx(expected, rel=1e-4, abs=0.01)


@ONE_RUN
@pytest.mark.parametrize(
    "build",
    [
        "four_stack: {levels: 7, step: 11.5 mm, spacing: 43 mm}",
        pytest.param("four_stack: {levels: 10, step: 11 mm}", marks=pytest.mark.slow),
        "column: {levels: 24, step: 5 mm}",
        "column: {levels: 4, step: 30 mm}",
    ],
)
def test_a_collapse_gains_no_energy(build: str) -> None:
    trace = collapse(build)
    assert trace.energy is not None
    assert trace.energy.gain < trace.energy.most_gain == 0.001


@ONE_RUN
def test_nothing_that_falls_is_frozen_before_it_has_landed() -> None:
    trace = collapse("four_stack: {levels: 7, step: 11.5 mm, spacing: 43 mm}")
    assert trace.onset is not None
    assert trace.landing is not None
    started = max(event.time for event in trace.events if event.kind is EventKind.PLACED)
    frozen = {
        brick
        for event in trace.events
        if event.kind is EventKind.FROZEN and started < event.time <= trace.landing.time
        for brick in event.bricks
    }
    assert not frozen & trace.onset.poses.keys()


# --- what makes it so -------------------------------------------------------------------------------------------------


def stepped(step: float, count: int) -> list[Placed]:
    return [
        Placed(Brick(f"p{n:02}", Box((LENGTH, WIDTH, THICKNESS)), MASS), Pose((step * n, 0.0, THICKNESS * (n + 0.5))))
        for n in range(count)
    ]


def world_of(bricks: Sequence[Placed], settings: PyBulletSettings = MOVING, friction: float = 0.5) -> PyBulletWorld:
    world = PyBulletWorld.opened(settings, G, friction, MASS)
    world.add_plane(replace(FLOOR, friction=friction))
    for placed in bricks:
        world.add_brick(placed.brick, placed.pose)
    world.freeze(bricks[0].brick.id)
    return world


def motion_of(bricks: Sequence[Placed], friction: float = 0.5) -> Motion:
    motion = Assembly([replace(FLOOR, friction=friction)], friction, G).add_all(bricks).motion
    assert motion is not None
    return motion


def parted_at(friction: float) -> float:
    """The turn at which planks that tip over the lowest one begin to move one by one [deg]."""
    bricks = stepped(0.011, 11)
    motion, world = motion_of(bricks, friction), world_of(bricks, friction=friction)
    falling = FallingParts(world, [replace(FLOOR, friction=friction)], friction, G)
    falling.woken(list(motion.velocity), motion)
    while falling.advance(10):
        pass
    turn = turn_between(bricks[-1].pose, world.states([bricks[-1].brick.id])[bricks[-1].brick.id].pose)
    world.close()
    return degrees(turn)


@pytest.mark.parametrize(("friction", "slides"), [(0.1, 10.5), (0.2, 17.9)])
def test_a_part_is_one_body_until_its_layers_would_slide(friction: float, slides: float) -> None:
    # The layers of a pendulum are pressed sideways less than at rest, where they would slide at 5.7 and 11.3 deg. The
    # angles are those of the closed form in tests/stability/dynamics/test_falling_part.py, asked at every fifth degree.
    assert slides - 5.0 < parted_at(friction) <= slides


def test_a_part_is_given_to_the_engine_before_it_strikes_what_stands_in_its_way_however_thin() -> None:
    # The end of the top plank comes down through x = 0.17 m, where a strip of 1 mm stands on edge.
    bricks = stepped(0.011, 11)
    strip = Placed(Brick("strip", Box((0.001, 0.02, 0.06)), 0.001), Pose((0.17, 0.0, 0.03)))
    world = world_of(bricks)
    world.add_brick(strip.brick, strip.pose)
    world.freeze("strip")
    motion = motion_of(bricks)
    falling = FallingParts(world, [FLOOR], 0.5, G)
    falling.woken(list(motion.velocity), motion)
    while falling.advance(10):
        pass
    states = world.states(sorted(motion.velocity))
    gaps = [
        apart(placed.brick.shape, states[placed.brick.id].pose, strip.brick.shape, strip.pose).gap
        for placed in bricks[1:]
    ]
    world.close()
    assert 0.0 <= min(gaps) < 0.002


def test_ten_steps_at_once_take_the_time_of_ten_single_steps() -> None:
    bricks = stepped(0.011, 11)
    motion, times = motion_of(bricks), []
    for at_once in (1, 10, 100):
        world = world_of(bricks)
        falling = FallingParts(world, [FLOOR], 0.5, G)
        falling.woken(list(motion.velocity), motion)
        assert sum(falling.advance(at_once) for _ in range(100 // at_once)) == 100
        times.append(world.time())
        world.close()
    assert times[0] == times[1] == times[2]  # to the last bit: limits of time are compared with it


def test_a_push_at_the_onset_of_a_falling_part_ends_the_part() -> None:
    bricks = stepped(0.011, 11)
    motion, world = motion_of(bricks), world_of(bricks)
    falling = FallingParts(world, [FLOOR], 0.5, G)
    falling.woken(list(motion.velocity), motion)
    falling.end()  # something is done before any time passes
    assert falling.advance(10) == 0
    world.close()


def test_a_brick_of_a_part_may_be_pulled_out_at_the_moment_when_that_begins_to_fall() -> None:
    timeline = timeline_of("- column: {levels: 5, step: 33 mm}")
    trace = play(replace(timeline, actions=(*timeline.actions, Removal(0.0, ("L5.1",)))), SYSTEMS["exact"])
    assert trace.tracks["L5.1"].state is BrickState.REMOVED


def sunk(settings: PyBulletSettings) -> float:
    """The fastest that any plank of a straight column moves in the first hundredth of a second of freedom [m/s]."""
    bricks = stepped(0.0, 10)
    world = world_of(bricks, settings)
    world.substep_next_contact()
    fastest = 0.0
    for _ in range(10):
        world.step()
        states = world.states([placed.brick.id for placed in bricks])
        fastest = max(fastest, *(hypot(*state.velocity_W) for state in states.values()))
    world.close()
    return fastest


def test_small_first_steps_make_the_kick_smaller_with_which_contacts_begin() -> None:
    # Before the first contact forces all fall freely for a step, and what that leaves grows with it.
    assert sunk(MOVING) < 0.5 * sunk(replace(MOVING, first_steps=0))


@pytest.mark.parametrize("system", ["exact", "tuned"])
@pytest.mark.parametrize("friction", [1e-160, 1e-300])
def test_a_plank_falls_with_next_to_no_friction_when_it_falls_with_none(system: str, friction: float) -> None:
    def falls_at(friction: float) -> float:
        build = "- column: {levels: 2, step: 60 mm}\n  every: 1 s"
        trace = play(timeline_of(build, f"friction: {friction}"), SYSTEMS[system])
        assert trace.collapse is not None
        return trace.collapse.time

    assert falls_at(friction) == pytest.approx(falls_at(0.0), abs=0.02)


def test_a_proven_fall_counts_though_the_run_ends_before_it_is_seen() -> None:
    #   18 mm a plank: the seventh is 108 mm out, and the six above the first balance 63 mm out, beyond its 58.8 mm. At
    #   0.001 m/s2 a plank falls by half a millimetre in a second.
    build = "- column: {levels: 8, step: 18 mm}\n  every: 1 s"
    rest = "world: {gravity: 0.001 m/s2}\nexpect: [{stands: all}]\nsystems: [exact]"
    cases, _ = compiled(scene(build, rest))
    trace = play(cases[0].timeline, SYSTEMS["exact"])
    (outcome,) = judge(trace, cases[0].scenario, cases[0].variant, cases[0].source, "exact")
    assert trace.statics is not None
    assert trace.statics.stability is Stability.UNSTABLE
    assert trace.verdict is RunVerdict.UNSETTLED
    assert not outcome.passed
    assert "has not come to rest" in outcome.measured


STEEP, GENTLE = degrees(atan(0.5)) + 0.002, degrees(atan(0.5)) - 0.002  # beside the slope that friction 0.5 holds [deg]


@pytest.mark.parametrize(
    ("slope", "dropped", "then"), [(STEEP, False, True), (STEEP, True, False), (GENTLE, True, True)]
)
def test_a_plank_that_slides_slower_than_the_watch_shows_does_not_stand(
    slope: float, dropped: bool, then: bool
) -> None:
    #   g (sin a - mu cos a) = 0.4 mm/s2 at 0.002 deg too steep: less than a millimetre in the two seconds of the watch.
    drop = "at: [0 mm, 0 mm, 3.91 mm], drop: true" if dropped else "at: [0 mm, 0 mm, 3.9 mm]"
    build = f"- bricks: [{{name: a, {drop}}}]\n  every: 0.3 s\n"
    build += "- bricks: [{name: rough, at: [0 mm, 100 mm, 3.9 mm]}]" if then else ""
    rubs = "friction: {between: [{pair: [rough, ground], friction: 0.9}]}" if then else ""
    cases, mistakes = compiled(scene(build, f"world: {{tilt: {slope} deg, {rubs}}}\nexpect: [{{stands: all}}]"))
    assert mistakes == []
    trace = play(cases[0].timeline, SYSTEMS["exact"])
    (outcome,) = judge(trace, cases[0].scenario, cases[0].variant, cases[0].source, "exact")
    assert trace.collapse is None
    assert trace.moving == ()
    assert outcome.passed == (slope == GENTLE)
    assert trace.verdict is (RunVerdict.STANDS if slope == GENTLE else RunVerdict.UNSETTLED)
    assert ("not settled when the simulation ended: a: a slides on ground" in outcome.measured) == (slope == STEEP)
    assert ("simulate longer, for example with `watch: 4 s`" in outcome.measured) == (slope == STEEP)


def test_where_levels_restart_the_step_that_falls_is_named() -> None:
    """Of three planks, each 40 mm beside the one below, the upper two have their centre 60 mm beside the lowest."""
    column = "- column: {levels: 3}\n  every: 1 s\n"
    top = "- name: top\n  column: {levels: 3, step: 40 mm, origin: [0 mm, 0 mm, 23.4 mm]}\n  every: 1 s"
    cases, _ = compiled(scene(column + top, "expect: [stands: all]"))
    trace = play(cases[0].timeline, SYSTEMS["exact"])
    assert trace.collapse is not None
    assert (trace.collapse.level, trace.collapse.step) == (3, "step 2 'top'")
    (outcome,) = judge(trace, cases[0].scenario, cases[0].variant, cases[0].source, "exact")
    assert "level 3 of step 2 'top'" in f"{outcome.measured} {trace.events[-2:]}"
