"""Bricks thrown and dropped at a structure, and pushes, compiled: where they begin, and that they arrive."""

from math import cos, radians, sin, sqrt

import pytest

from stability.geometry.placed_shape import apart
from stability.geometry.vectors import add, add_scaled, body_axes, norm, scale, subtract
from stability.model import Pose, Vec3
from stackdsl.timeline import Arrival, Placement, PushAction, Timeline
from tests.scenes import assert_told_in_its_place, mistakes_of, timeline_of

LENGTH, WIDTH, THICKNESS = 0.1176, 0.0234, 0.0078  # of a KAPLA plank [m]
TOWER = "- four_stack: {levels: 13}\n  every: 1 s"
KAPLA = (LENGTH, WIDTH, THICKNESS)


def hit(impact: str, build: str = TOWER, rest: str = "") -> tuple[Placement, Timeline]:
    """The brick that comes, and all that happens."""
    timeline = timeline_of(build, f"impacts: [{impact}]\n{rest}")
    return next(placement for placement in timeline.placements if placement.hits), timeline


def at_time(placement: Placement, time: float, gravity: float = 9.81) -> Vec3:
    """Where a brick that flies freely is after a time [m]."""
    straight = add(placement.pose.position_W, scale(time, placement.velocity_W))
    return add_scaled(straight, 0.5 * gravity * time * time, (0.0, 0.0, -1.0))


def nearest(brick: Placement, pose: Pose, timeline: Timeline) -> tuple[float, str]:
    """The gap to the brick of the structure that is nearest [m], and its name."""
    others = [placement for placement in timeline.placements if not placement.hits]
    gaps = [(apart(brick.brick.shape, pose, each.brick.shape, each.pose).gap, each.brick.id) for each in others]
    return min(gaps)


@pytest.mark.parametrize("distance", [0.0, 0.01, 0.3, 2.0])
@pytest.mark.parametrize("speed", [1.0, 8.0, 20.0])
def test_a_thrown_brick_arrives_at_the_height_of_its_aim_whatever_the_distance(distance: float, speed: float) -> None:
    #  ___            it rises by g T^2 / 8 and is back when its nose has covered the distance, T = distance / speed
    # |___| - - - ->|
    impact = f"{{throw: {{at: level 3, from: {{bearing: 90 deg, distance: {distance} m}}, speed: {speed} m/s}}}}"
    brick, timeline = hit(impact)
    duration = distance / speed
    assert brick.velocity_W == pytest.approx((0.0, -speed, 9.81 * duration / 2), abs=1e-12)
    #  Level 3 lies along x; the outer face of its plank on the +y side is at L / 2, so the centre stops at L.
    assert brick.pose.position_W == pytest.approx((0.0, LENGTH + distance, 2.5 * THICKNESS), abs=1e-12)
    arrives = at_time(brick, duration)
    assert arrives == pytest.approx((0.0, LENGTH, 2.5 * THICKNESS), abs=1e-12)
    gap, name = nearest(brick, Pose(arrives, brick.pose.orientation), timeline)
    assert gap == pytest.approx(0.0, abs=1e-12)
    assert name == "L3.2"


@pytest.mark.parametrize(
    ("speed", "distance", "fastest", "remedy"),
    [
        #  up at g T / 2, T = distance / speed
        (
            "1e-3 m/s",
            "100 mm",
            "490.5",
            "throw it at 0.0246 m/s or faster, or throw it from a distance of at most 4.07 mm",
        ),
        ("1 m/s", "10 m", "49.05", "throw it at 2.46 m/s or faster, or throw it from a distance of at most 4070 mm"),
        ("20 m/s", "100 m", "24.53", "throw it from a distance of at most 81500 mm"),
        (
            "1e-300 m/s",
            "100 mm",
            "4.905e+299",
            "throw it at 0.0246 m/s or faster, or throw it from a distance of at most 4.07e-297 mm",
        ),
    ],
)
def test_a_throw_so_slow_that_it_would_rise_faster_than_it_may_be_thrown_is_told_with_the_remedy(
    speed: str, distance: str, fastest: str, remedy: str
) -> None:
    throw = f"{{throw: {{at: L2.1, from: {{bearing: 0 deg, distance: {distance}}}, speed: ^{speed}}}}}"
    assert_told_in_its_place(throw, "SD104", f"reaches {fastest} m/s; the maximum is 20 m/s")
    (mistake,) = mistakes_of("- column: {levels: 2}", f"impacts: [{throw.replace('^', '')}]")
    assert mistake.hint == remedy


@pytest.mark.parametrize("towards", [0, 70, 180])
@pytest.mark.parametrize("speed", [0.3, 10.0, 20.0])
def test_a_throw_at_the_limits_that_it_is_told_is_let_pass_and_no_faster_than_they_say(
    towards: int, speed: float
) -> None:
    tilt = f"world: {{tilt: {{angle: 20 deg, towards: {towards} deg}}}}"
    throw = "{throw: {at: L2.1, from: {bearing: 0 deg, distance: DISTANCE}, speed: SPEED}}"
    far = throw.replace("DISTANCE", "300 m").replace("SPEED", f"{speed} m/s")
    (mistake,) = mistakes_of("- column: {levels: 2}", f"impacts: [{far}]\n{tilt}")
    near = throw.replace("DISTANCE", mistake.hint.split("at most ")[1])
    brick, _ = hit(near.replace("SPEED", f"{speed} m/s"), "- column: {levels: 2}", tilt)
    leaving, arriving = brick.velocity_W[2], brick.velocity_W[2] - 9.81 * brick.flight
    assert 19.8 < max(abs(leaving), abs(arriving)) <= 20.0 + 1e-9


@pytest.mark.parametrize("bearing", [0, 45, 90, 200, 359])
def test_a_thrown_brick_flies_end_on_from_its_bearing(bearing: float) -> None:
    brick, _ = hit(f"{{throw: {{at: L13.1, from: {{bearing: {bearing} deg}}, speed: 2 m/s}}}}")
    length_W, _, thickness_W = body_axes(brick.pose.orientation)
    along = (cos(radians(bearing)), sin(radians(bearing)), 0.0)
    assert length_W == pytest.approx(along, abs=1e-12)
    assert thickness_W == (0.0, 0.0, 1.0)
    assert brick.velocity_W[:2] == pytest.approx((-2 * along[0], -2 * along[1]), abs=1e-12)


def test_a_brick_that_is_turned_by_a_quarter_comes_broadside() -> None:
    #  Its half width is what is before its centre now; it covers both ends of level 12, at y = 47 mm to either side.
    brick, timeline = hit("{throw: {at: level 12, turn: 90 deg, from: {bearing: 0 deg}, speed: 2 m/s}}")
    assert brick.pose.position_W == pytest.approx((LENGTH / 2 + WIDTH / 2 + 0.01, 0.0, 11.5 * THICKNESS), abs=1e-12)
    assert body_axes(brick.pose.orientation)[0] == pytest.approx((0.0, 1.0, 0.0), abs=1e-12)
    assert nearest(brick, brick.pose, timeline)[0] == pytest.approx(0.01, abs=1e-12)


def test_the_distance_of_a_skew_hit_is_measured_along_the_flight() -> None:
    #    \\         at 30 deg, the corner of the nose is the first to meet the face x = w / 2 of a plank along y
    #     \\__|
    build = "- bricks: [{at: [0 mm, 0 mm, 3.9 mm], rotate: [0 deg, 0 deg, 90 deg]}]"
    brick, _ = hit("{throw: {at: level 1, from: {bearing: 30 deg, distance: 40 mm}, speed: 1 m/s}}", build)
    reach = (LENGTH * cos(radians(30)) + WIDTH * sin(radians(30)) + WIDTH) / 2  # of both along x
    expected = reach / cos(radians(30)) + 0.04
    assert norm((*brick.pose.position_W[:2], 0.0)) == pytest.approx(expected, abs=1e-12)


def test_removed_and_later_bricks_do_not_block_a_throw() -> None:
    build = "- column: {levels: 1}\n- column: {levels: 1, origin: [200 mm, 0 mm, 0 mm]}\n  name: later\n  at: 9 s"
    throw = "throw: {at: L1.1, from: {bearing: 0 deg}, speed: 1 m/s}"
    early, _ = hit(f"{{at: 5 s, {throw}}}", build)
    late, _ = hit(throw.join("{}"), build)
    cleared, _ = hit(f"{{remove: {{brick: later.L1.1}}}}, {{{throw}}}", build)
    assert [each.pose.position_W[0] for each in (early, late, cleared)] == pytest.approx(
        [LENGTH + 0.01, 0.2 + LENGTH + 0.01, LENGTH + 0.01], abs=1e-12
    )


@pytest.mark.parametrize("towards", [0, 70, 180])
def test_in_a_tilted_scene_gravity_bends_the_flight_and_it_still_arrives(towards: float) -> None:
    tilt = f"world: {{tilt: {{angle: 20 deg, towards: {towards} deg}}, gravity: 3 m/s2}}"
    throw = "{throw: {at: L2.1, from: {bearing: 0 deg, distance: 0.5 m}, speed: 2 m/s}}"
    brick, timeline = hit(throw, "- column: {levels: 2}", tilt)
    aim = next(placement.pose for placement in timeline.placements if placement.brick.id == "L2.1")
    arrives = at_time(brick, 0.25, gravity=3.0)
    #  end to end with what it is aimed at, along the tilted length of that
    assert arrives == pytest.approx(add_scaled(aim.position_W, LENGTH, body_axes(aim.orientation)[0]), abs=1e-12)
    assert subtract(brick.pose.position_W, arrives) == pytest.approx(
        scale(0.5, body_axes(aim.orientation)[0]), abs=1e-12
    )


def test_thrown_and_dropped_bricks_are_of_no_level_and_come_at_the_time_of_the_impact() -> None:
    impacts = """
    impacts:
      - {after: built + 2 s, throw: {at: level 3, from: {bearing: 90 deg}, speed: 1 m/s}}
      - {drop: {onto: L13.1, height: 1 m, brick: {size: [40 mm, 40 mm, 40 mm], mass: 50 g}}}
      - {throw: {at: thirteen, name: shot, from: {bearing: 0 deg}, speed: 1 m/s}}
    """
    build = f"{TOWER}\n- bricks: [{{name: thirteen, at: [500 mm, 0 mm, 3.9 mm]}}]"
    timeline = timeline_of(build, impacts)
    coming = [placement for placement in timeline.placements if placement.hits]
    assert [(each.brick.id, each.time, each.level, each.arrival) for each in coming] == [
        ("thrown-1", 28.0, 0, Arrival.THROWN),
        ("dropped-2", 28.0, 0, Arrival.DROPPED),
        ("shot", 28.0, 0, Arrival.THROWN),
    ]
    assert (timeline.levels, timeline.built) == (13, 26.0)
    assert coming[1].brick.mass == pytest.approx(0.05)


# --- drops ------------------------------------------------------------------------------------------------------------


def test_a_dropped_brick_lies_along_what_it_falls_onto_at_its_height_above() -> None:
    brick, _ = hit("{drop: {onto: L12.2, height: 100 mm}}", "- four_stack: {levels: 12, heading: 30 deg}")
    half = (LENGTH - WIDTH) / 2
    x, y = half * cos(radians(30)), half * sin(radians(30))
    assert brick.pose.position_W == pytest.approx((x, y, 12.5 * THICKNESS + 0.1), abs=1e-12)
    assert body_axes(brick.pose.orientation)[0] == pytest.approx((-sin(radians(30)), cos(radians(30)), 0), abs=1e-12)
    assert brick.velocity_W == (0.0, 0.0, 0.0)


def test_a_brick_dropped_on_its_corner_is_let_go_by_its_lowest_point() -> None:
    #  /\     turned by 90 deg about x, then 40 deg about y: it comes with a corner first
    #  \/     and its lowest point is (L sin + w cos) / 2 below its centre
    rotate = "rotate: [90 deg, 40 deg, 0 deg]"
    brick, _ = hit(f"{{drop: {{onto: level 1, height: 50 mm, {rotate}}}}}", "- column: {levels: 1}")
    lowest = (LENGTH * sin(radians(40)) + WIDTH * cos(radians(40))) / 2
    assert brick.pose.position_W == pytest.approx((0.0, 0.0, THICKNESS + 0.05 + lowest), abs=1e-12)


def test_in_a_tilted_scene_a_brick_falls_upright_by_its_height() -> None:
    brick, timeline = hit("{drop: {onto: L2.1, height: 80 mm}}", "- column: {levels: 2}", "world: {tilt: 15 deg}")
    aim = timeline.placements[1].pose
    x, y, z = aim.position_W
    #  face on face, so it is a thickness along the normal, which is t / cos upright
    up = THICKNESS / cos(radians(15)) + 0.08
    assert brick.pose.position_W == pytest.approx((x, y, z + up), abs=1e-12)
    assert sqrt(2 * 9.81 * 0.08) == pytest.approx(1.2528, abs=1e-4)  # and this fast it arrives
    assert brick.pose.orientation == aim.orientation


# --- pushes -----------------------------------------------------------------------------------------------------------


def test_a_push_turns_with_the_scene() -> None:
    push = "{push: {brick: L2.1, impulse: [10 mN*s, 0 g*m/s, 0 kg*m/s], point: [0 mm, 11.7 mm, 0 mm]}}"
    level = timeline_of("- column: {levels: 2}", f"impacts: [{push}]").actions[-1]
    assert level == PushAction(0.0, "L2.1", (0.01, 0.0, 0.0), (0.0, 0.0117, 0.0))
    rest = f"impacts: [{push}]\nworld: {{tilt: {{angle: 30 deg, towards: 0 deg}}}}"
    tilted = timeline_of("- column: {levels: 2}", rest).actions[-1]
    assert isinstance(tilted, PushAction)
    assert tilted.impulse_W == pytest.approx((0.01 * cos(radians(30)), 0.0, -0.01 * sin(radians(30))), abs=1e-15)


def test_a_thrown_brick_may_be_pushed_and_removed() -> None:
    throw = "{throw: {at: L1.1, from: {bearing: 0 deg}, speed: 1 m/s, name: shot}}"
    push = "{after: impact 1 + 1 s, push: {brick: shot, impulse: [1 mN*s, 0 N*s, 0 N*s]}}"
    timeline = timeline_of("- column: {levels: 1}", f"impacts: [{throw}, {push}, {{remove: {{brick: shot}}}}]")
    assert [type(action).__name__ for action in timeline.actions] == ["Placement", "Placement", "PushAction", "Removal"]


# --- mistakes ---------------------------------------------------------------------------------------------------------

FROM = "from: {bearing: 0 deg}, speed: 1 m/s"
CUBE = "{size: [40 mm, 40 mm, 40 mm], mass: 50 g}"


@pytest.mark.parametrize(
    ("impacts", "code", "words"),  # ^ marks the place that is told
    [
        (f"{{throw: {{at: ^level 9, {FROM}}}}}", "SD205", "no brick of level 9 stands at 8 s"),
        (f"{{at: 1 s, throw: {{at: ^level 2, {FROM}}}}}", "SD205", "no brick of level 2 stands at 1 s"),
        (f"{{throw: {{at: ^roof, {FROM}}}}}", "SD204", "there is no brick 'roof'"),
        ("{drop: {onto: ^roof, height: 1 m}}", "SD204", "there is no brick 'roof'"),
        ("{push: {brick: ^roof, impulse: [1 N*s, 0 N*s, 0 N*s]}}", "SD204", "there is no brick 'roof'"),
        (f"{{at: 1 s, throw: {{at: ^L2.1, {FROM}}}}}", "SD204", "'L2.1' is not placed before 4 s"),
        ("{at: 1 s, push: {brick: ^L2.1, impulse: [1 N*s, 0 N*s, 0 N*s]}}", "SD204", "not placed before 4 s"),
        (f"{{remove: {{brick: L2.1}}}}, {{throw: {{at: ^L2.1, {FROM}}}}}", "SD204", "no longer present at 8 s"),
        (f"{{throw: {{at: L1.1, {FROM}}}}}, {{drop: {{onto: ^thrown-1, height: 1 m}}}}", "SD204", "flies or falls"),
        ("{throw: {at: ^L0:1, " + FROM + "}}", "SD104", "'L0:1' is not a target"),
        ("{throw: {at: ^level 0, " + FROM + "}}", "SD104", "not a target"),
        ("{throw: {at: L1.1, from: {bearing: 0 deg}, speed: ^0 m/s}}", "SD104", "not greater than zero"),
        ("{throw: {at: L1.1, from: {bearing: 0 deg}, speed: ^20.1 m/s}}", "SD104", "a speed of 20.1 m/s is out of"),
        ("{throw: {at: L1.1, from: {bearing: 0 deg}, speed: ^2}}", "SD105", "has no unit; expected a speed"),
        ("{throw: {at: L1.1, from: {bearing: 0 deg, distance: ^-1 mm}, speed: 2 m/s}}", "SD104", "out of range"),
        (f"{{throw: {{at: L1.1, brick: {CUBE}, from: ^{{bearing: 0 deg}}, speed: 2 m/s}}}}", "SD201", "16.1 mm inside"),
        (f"{{throw: {{at: L1.1, name: ^L2.1, {FROM}}}}}", "SD203", "two bricks have the name 'L2.1'"),
        (f"{{throw: {{at: L1.1, name: a, {FROM}}}}}, {{drop: {{onto: L2.1, name: ^a, height: 1 m}}}}", "SD203", "'a'"),
        ("{drop: {onto: ^L1.1, height: 1 m}}", "SD207", "brick 'L2.1' blocks the path of brick 'dropped-1'"),
        ("{drop: {onto: L2.1, height: ^0 mm}}", "SD104", "not greater than zero"),
        ("{push: {brick: L1.1, impulse: [1 N*s, ^1 N, 0 N*s]}}", "SD106", "'N' is not a unit of an impulse"),
        ("{push: {brick: L1.1, impulse: [1 N*s, 0 N*s, 0 N*s], point: ^[0 mm, 0 mm, 5 mm]}}", "SD207", "1.1 mm out"),
        ("{push: {brick: L1.1, impulse: ^[0 N*s, 0 N*s, 0 N*s]}}", "SD104", "accelerates brick 'L1.1' to 0 m/s"),
        (f"{{throw: {{at: L1.1, {FROM}}}}}, {{push: {{brick: thrown-1, impulse: ^[1 N*s, 0 N*s, 0 N*s]}}}}",
         "SD104", "brick 'thrown-1' to 83.64 m/s"),
        (f"{{remove: {{brick: ^thrown-2}}}}, {{at: 9 s, throw: {{at: L1.1, {FROM}}}}}", "SD204", "not placed before 9"),
        (
            "{push: {brick: ^a, impulse: [1 N*s, 0 N*s, 0 N*s]}}, "
            f"{{at: 9 s, throw: {{name: a, at: L1.1, {FROM}}}}}",
            *("SD204", "brick 'a' does not exist before 9 s, but this impact begins at 8 s"),
        ),
    ],
)  # fmt: skip
def test_a_hit_that_cannot_be_is_told_in_its_place(impacts: str, code: str, words: str) -> None:
    assert_told_in_its_place(impacts, code, words)


SHOT = "throw: {at: L1.1, from: {bearing: 0 deg, distance: 0.3 m}, speed: 2 m/s}"
LET_GO = "drop: {onto: L1.1, height: 50 mm}"


@pytest.mark.parametrize(
    ("first", "later", "depth"),  # the first shot rises with g T / 2, T = 0.15 s; each plank is 7.8 mm thick
    [
        (SHOT, f"at: 5 s, {SHOT}", "7.8 mm inside"),
        (SHOT, f"at: 5.01 s, {SHOT}", "0.933 mm inside"),  # 7.3575 - 0.4905 mm up by then
        (SHOT, f"at: 5.0115 s, {SHOT}", ""),  # 7.81 mm
        (LET_GO, f"at: 5 s, {LET_GO}", "7.8 mm inside"),
        (LET_GO, f"at: 5.03 s, {LET_GO}", "3.385 mm inside"),  # 4.4145 mm down
        (LET_GO, f"at: 5.04 s, {LET_GO}", ""),  # 7.85 mm
        (SHOT, f"at: 5 s, remove: {{brick: thrown-1}}}}, {{at: 5 s, {SHOT}", ""),
        (SHOT, f"at: 5 s, push: {{brick: thrown-1, impulse: [1 mN*s, 0 N*s, 0 N*s]}}}}, {{at: 5 s, {SHOT}", ""),
    ],
)
def test_a_brick_does_not_begin_where_another_one_flies(first: str, later: str, depth: str) -> None:
    head = f"impacts: [{{at: 5 s, {first}}}, {{"
    mistakes = mistakes_of("- column: {levels: 1}", f"\n{head}{later}}}]")
    assert len(mistakes) == bool(depth)
    for mistake in mistakes:
        assert (mistake.code, depth in mistake.message) == ("SD201", True), mistake.message
        assert mistake.message.endswith("which is still in flight from 5:21")
        assert (mistake.span.line, mistake.span.column) == (5, len(head) + later.index(", ") + 3)
        assert mistake.hint.startswith("start it later, for example with `after: impact 1 + 0.5 s`")


def test_a_throw_that_passes_between_two_planks_is_told() -> None:
    #  = =   along x, between the two planks of level 3, above level 2 and below level 4
    (mistake,) = mistakes_of(TOWER, f"impacts: [{{throw: {{at: level 3, {FROM}}}}}]")
    assert (mistake.code, mistake.message) == ("SD207", "brick 'thrown-1' misses all bricks")
    assert "turn: 90 deg" in mistake.hint


def test_a_drop_that_falls_past_its_level_is_told() -> None:
    (mistake,) = mistakes_of(TOWER, "impacts: [{drop: {onto: level 13, height: 1 m}}]")
    assert mistake.code == "SD207"
    assert "misses its target" in mistake.message


def test_nobody_knows_where_a_brick_that_was_let_go_lies() -> None:
    build = "- bricks: [{name: a, at: [0 mm, 0 mm, 50 mm], drop: true}]"
    for impact in (f"throw: {{at: a, {FROM}}}", "drop: {onto: a, height: 1 m}"):
        (mistake,) = mistakes_of(build, f"impacts: [{{at: 1 s, {impact}}}]")
        assert (mistake.code, "flies or falls" in mistake.message) == ("SD204", True)
    assert mistakes_of(build, "impacts: [{push: {brick: a, impulse: [1 mN*s, 0 N*s, 0 N*s]}}]") == []


def test_a_brick_does_not_come_through_a_wall() -> None:
    walls = "world: {walls: [{bearing: 0 deg, distance: 0.15 m}]}"
    (mistake,) = mistakes_of("- column: {levels: 1}", f"impacts: [{{throw: {{at: level 1, {FROM}}}}}]\n{walls}")
    #  its far end is 3 L / 2 + 10 mm out
    assert (mistake.code, mistake.message) == ("SD201", "brick 'thrown-1' starts 36.4 mm inside wall1")


def test_a_push_makes_a_brick_no_faster_than_one_that_is_thrown() -> None:
    #  0.11956 N s are 10 m/s for 11.956 g, along x and along y, so 14.1 m/s together; 20 m/s are 239.1 mN s.
    for along, known in ((0.11956, True), (0.1691, False)):
        push = f"{{push: {{brick: L1.1, impulse: [{along} N*s, {-along} N*s, 0 N*s]}}}}"
        mistakes = mistakes_of("- column: {levels: 1}", f"impacts: [{push}]")
        assert (mistakes == []) is known
    assert mistakes[0].hint == "write an impulse greater than 0 and at most 239 mN*s"


@pytest.mark.parametrize(
    "claim",
    [
        "stands: {bricks: [^shot]}", "falls: {bricks: [L1.1, ^shot]}", "collapses: {brick: ^shot}",
        "untouched: {bricks: [^shot]}", "untouched: {except: [^shot]}", "drift: {is: < 1 mm, bricks: [^shot]}",
        "height: {is: < 8 mm, of: ^shot}", "rests_on: {brick: ^shot, support: L2.1}",
    ],
)  # fmt: skip
@pytest.mark.parametrize(
    ("impact", "word"),
    [
        (f"throw: {{at: L2.1, name: shot, {FROM}}}", "thrown"),
        ("drop: {onto: L2.1, name: shot, height: 1 m}", "dropped"),
    ],
)
def test_nothing_is_expected_of_a_brick_that_hits(claim: str, impact: str, word: str) -> None:
    rest = f"impacts: [{{{impact}}}]\nexpect: [{{{claim.replace('^', '')}}}]"
    (mistake,) = mistakes_of("- column: {levels: 2}", rest)
    assert (mistake.code, mistake.span.line) == ("SD204", 5)
    assert mistake.span.column == len("expect: [{") + claim.index("^") + 1
    assert mistake.message.startswith(f"brick 'shot' is {word} and not part of the structure")
    assert mistakes_of("- column: {levels: 2}", rest.replace("shot", "hit", 1).replace("shot", "L2.1")) == []


def test_a_brick_may_rest_on_one_that_hit() -> None:
    impacts = f"impacts: [{{throw: {{at: L2.1, name: shot, {FROM}}}}}]"
    claim = "expect: [{rests_on: {brick: L2.1, support: shot}}]"
    assert mistakes_of("- column: {levels: 2}", f"{impacts}\n{claim}") == []
