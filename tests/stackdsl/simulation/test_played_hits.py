"""What a hit does to a structure: what counts as fallen, what as displaced, and what goes on after a collapse."""

from math import degrees, hypot, radians, sin, sqrt

import pytest

from stability.geometry.box import Box
from stability.model import BodyState, Brick, Pose, Vec3
from stackdsl.language.claims.stands import Stands
from stackdsl.report.text import EventLines
from stackdsl.simulation.brick_tracks import BrickTracker
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.timeline import Arrival, Placement
from stackdsl.trace import BrickState, EventKind, RunVerdict, Trace
from tests.scenes import timeline_of

GRAVITY, FRICTION = 9.81, 0.5
SIZE = (0.1176, 0.0234, 0.0078)  # so that a brick has left its place when it shifted, or sank, by more than 3.9 mm
MASS = 557.0 * SIZE[0] * SIZE[1] * SIZE[2]
PLANK = Brick("plank", Box(SIZE), MASS)
SHOT = Brick("shot", Box(SIZE), MASS)
TABLE = Pose((0.0, 0.0, 0.1))


def watched(moves: Vec3, tilt: float = 0.0, hit: bool = True) -> BrickTracker:
    """A plank at rest that gets so far [m], turned by so much [rad], after a hit or without one."""
    watch = BrickTracker()
    watch.add(Placement(0.0, PLANK, 1, TABLE))
    if hit:
        watch.add(Placement(1.0, SHOT, 0, Pose((0.5, 0.0, 0.1)), Arrival.THROWN, (-1.0, 0.0, 0.0)))
    x, y, z = moves
    pose = Pose((x, y, 0.1 + z), (sin(0.5 * tilt), 0.0, 0.0, sqrt(1.0 - sin(0.5 * tilt) ** 2)))
    watch.see(2.0, {"plank": BodyState(pose)})
    return watch


@pytest.mark.parametrize(
    ("moves", "tilt", "before_a_hit", "after_one"),
    [
        ((0.0035, 0.0, 0.0), 0.0, BrickState.STANDING, BrickState.STANDING),
        ((0.02, 0.0, 0.0), 0.0, BrickState.FALLEN, BrickState.DISPLACED),
        ((0.02, 0.0, -0.0035), 0.0, BrickState.FALLEN, BrickState.DISPLACED),
        ((0.02, 0.0, -0.0045), 0.0, BrickState.FALLEN, BrickState.FALLEN),
        ((0.0, 0.0, -0.0045), 0.0, BrickState.FALLEN, BrickState.FALLEN),
        ((0.02, 0.0, 0.0), 14.0, BrickState.FALLEN, BrickState.DISPLACED),
        ((0.0, 0.0, 0.0), 16.0, BrickState.FALLEN, BrickState.FALLEN),
    ],
)
def test_after_a_hit_only_what_sank_or_tilts_has_left_its_place(
    moves: Vec3, tilt: float, before_a_hit: BrickState, after_one: BrickState
) -> None:
    for hit, expected in ((False, before_a_hit), (True, after_one)):
        watch = watched(moves, radians(tilt), hit)
        assert watch.bricks["plank"].state(frozen=False) is expected
        assert watch.first_to_leave() == ("plank" if expected is BrickState.FALLEN else None)


@pytest.mark.parametrize(
    ("moves", "tilt", "hit", "told"),
    [
        ((0.012, 0.0, 0.0), 0.0, False, "moved 12 mm"),
        ((0.02, 0.0, -0.0045), 0.0, True, "sunk 4.5 mm"),
        ((0.02, 0.0, 0.0), 16.0, True, "tilted 16 deg"),
    ],
)
def test_a_fall_is_told_by_the_motion_that_makes_it_one(moves: Vec3, tilt: float, hit: bool, told: str) -> None:
    watch = watched(moves, radians(tilt), hit)
    watch.see(3.0, {"plank": BodyState(Pose((0.0, 0.0, 0.0039)))})  # where it lies later is not what is told
    assert watch.bricks["plank"].left_by == told


def test_a_brick_that_rocks_beyond_the_limit_and_stands_again_tells_by_how_much_it_fell() -> None:
    watch = watched((0.0, 0.0, 0.0), radians(15.5))
    half = 0.5 * radians(10.0)
    watch.see(3.0, {"plank": BodyState(Pose((0.003, 0.0, 0.1015), (sin(half), 0.0, 0.0, sqrt(1.0 - sin(half) ** 2))))})
    track = watch.bricks["plank"].track(frozen=True)
    assert (track.state, track.fell_by, track.stands_again) == (BrickState.FALLEN, "tilted by 15.5 deg", True)
    assert degrees(track.end_tilt) == pytest.approx(10.0)
    assert track.end_shift == pytest.approx(hypot(0.003, 0.0015))
    lying = watched((0.0, 0.0, -0.0045)).bricks["plank"].track(frozen=True)
    assert (lying.fell_by, lying.stands_again) == ("sank by 4.5 mm", False)
    assert not watched((0.02, 0.0, 0.0)).bricks["plank"].track(frozen=True).fell_by


def test_what_fell_before_a_hit_stays_fallen() -> None:
    watch = watched((0.02, 0.0, 0.0), hit=False)
    watch.struck()
    assert watch.bricks["plank"].state(frozen=True) is BrickState.FALLEN


def test_a_missile_is_no_part_of_the_structure_wherever_it_goes() -> None:
    watch = watched((0.0, 0.0, 0.0))
    watch.see(3.0, {"shot": BodyState(Pose((0.0, 0.0, -1.0)))})
    assert watch.first_to_leave() is None
    assert watch.last_built().level == 1
    track = watch.bricks["shot"].track(frozen=True)
    assert (track.state, track.shift) == (BrickState.THROWN, 0.0)


# --- played -----------------------------------------------------------------------------------------------------------


def played(build: str, impact: str, system: str = "tuned", rest: str = "") -> Trace:
    return play(timeline_of(build, f"impacts: [{impact}]\n{rest}"), SYSTEMS[system])


@pytest.mark.parametrize(("system", "state"), [("tuned", BrickState.DISPLACED), ("exact", BrickState.DISPLACED)])
def test_a_plank_that_is_pushed_slides_as_far_as_friction_lets_it_and_stands(system: str, state: BrickState) -> None:
    speed = 0.3  # v^2 / (2 mu g) are 9.17 mm
    impulse = f"[{MASS * speed} N*s, 0 N*s, 0 N*s]"
    push = f"{{after: built + 0.5 s, push: {{brick: L3.1, impulse: {impulse}}}}}"
    trace = played("- column: {levels: 3}", push, system, "expect: [{stands: {for: 1 s}}]")
    assert trace.verdict is RunVerdict.STANDS
    assert trace.tracks["L3.1"].state is state
    assert trace.tracks["L3.1"].shift == pytest.approx(speed**2 / (2.0 * FRICTION * GRAVITY), rel=0.05)
    assert [event.bricks for event in trace.events if event.kind is EventKind.PUSHED] == [("L3.1",)]


THROW = "{at: 0.5 s, throw: {at: L1.1, from: {bearing: 90 deg, distance: 50 mm}, speed: 2 m/s, name: shot}}"
FALLS = "- bricks: [{name: post, at: [0 mm, 0 mm, 58.916 mm], rotate: [0 deg, -85 deg, 0 deg]}]"


def test_hits_go_on_after_a_collapse_and_building_does_not() -> None:
    build = "- column: {levels: 1, origin: [500 mm, 0 mm, 0 mm]}\n" + FALLS
    late = "{at: 2 s, insert: {name: late, at: [0 mm, 300 mm, 3.9 mm]}}"
    push = "{at: 3 s, push: {brick: post, impulse: [0 N*s, 0.001 N*s, 0 N*s]}}"
    throw = THROW.replace("L1.1", "post").replace("0.5 s", "4 s")
    trace = played(build, ", ".join([late, push, throw]), rest="expect: [{stands: {bricks: [L1.1], for: 0.5 s}}]")
    assert trace.collapse is not None
    assert trace.collapse.time < 1.0
    assert trace.tracks["late"].state is BrickState.UNPLACED
    assert trace.tracks["shot"].state is BrickState.THROWN
    assert [event.time for event in trace.events if event.kind is EventKind.PUSHED] == [3.0]
    assert trace.last_action == 4.0
    assert trace.cost.simulated_time == pytest.approx(4.525, abs=0.01)  # the shot flies 50 mm first


def test_what_a_hit_brings_down_is_followed_as_long_as_the_hit_itself() -> None:
    #   An upright plank is knocked over in well under a second; what is expected of the rest may take longer.
    build = "- column: {levels: 1, origin: [500 mm, 0 mm, 0 mm]}\n"
    post = "- bricks: [{name: post, at: [0 mm, 0 mm, 58.8 mm], rotate: [0 deg, 90 deg, 0 deg]}]"
    push = "{after: built + 0.1 s, push: {brick: post, impulse: [0.01 N*s, 0 N*s, 0 N*s]}}"
    trace = played(build + post, push, rest="expect: [{stands: {bricks: [L1.1], for: 2.5 s}}]")
    assert trace.collapse is not None
    assert trace.collapse.time < 0.5
    assert trace.cost.simulated_time == pytest.approx(2.6, abs=0.01)


@pytest.mark.parametrize(
    ("hit", "flight"),
    [
        ("throw: {at: post, from: {bearing: 0 deg, distance: 3 m}, speed: 2 m/s}", 1.5),
        ("drop: {onto: post, height: 4.905 m, rotate: [0 deg, 90 deg, 30 deg]}", 1.0),  # sqrt(2 h / g)
    ],
)
def test_a_hit_is_waited_for_until_it_arrives(hit: str, flight: float) -> None:
    #  The post is knocked over, but not before what comes has flown for longer than the watch lasts.
    build = "- bricks: [{name: post, at: [0 mm, 0 mm, 58.8 mm], rotate: [0 deg, 90 deg, 0 deg]}]"
    timeline = timeline_of(build, f"impacts: [{{at: 0.5 s, {hit}}}]\nexpect: [{{stands: {{for: 0.5 s}}}}]")
    assert timeline.end == pytest.approx(0.5 + flight + 0.5)
    trace = play(timeline, SYSTEMS["tuned"])
    assert trace.last_action == 0.5
    assert trace.last_arrival == pytest.approx(0.5 + flight)
    assert trace.cost.simulated_time >= timeline.end - 0.01
    (contact,) = (event for event in trace.events if event.kind is EventKind.HIT)
    assert contact.time == pytest.approx(0.5 + flight, abs=0.005)  # told in the step of the engine in which it hits
    if hit.startswith("throw"):
        # It is thrown up at 7.36 m/s to come back at its height: hypot(2, 7.36) = 7.62.
        assert contact.reason == f"{contact.bricks[0]} hits post at 7.62 m/s, 2 m/s of it into the face"
        assert trace.tracks["post"].state is BrickState.FALLEN
        assert not Stands(**{"for": "0.5 s"}).judge(trace).passed


# A wall of 4 courses, a soft ball and a hard one, from the side and on a wall that is turned. Gravity bends the flight,
# but not its horizontal speed, so a ball arrives after its distance divided by its speed.


WALL = "- wall: {{levels: 4, bricks: 3, gap: 5 mm, heading: {heading} deg}}"
BALL = (
    "throw: {{at: L4.2, from: {{bearing: {bearing} deg, distance: 1 m}}, speed: {speed} m/s, name: ball, brick: ball}}"
)
SCENE = (
    "brick: {{size: [200 mm, 100 mm, 65 mm], density: 1900 kg/m3}}\n"
    "brick_types: {{ball: {{size: [60 mm, 60 mm, 60 mm], density: {density} kg/m3}}}}"
)


@pytest.mark.parametrize(
    ("heading", "speed", "density"), [(0.0, 6.0, 50.0), (0.0, 8.0, 2000.0), (30.0, 8.0, 2000.0)], ids=str
)
def test_a_ball_hits_when_it_has_crossed_its_distance_and_not_when_bricks_wake(
    heading: float, speed: float, density: float
) -> None:
    hit = BALL.format(bearing=heading + 90.0, speed=speed)
    trace = played(WALL.format(heading=heading), f"{{at: 0.5 s, {hit}}}", "exact", SCENE.format(density=density))
    (contact,) = (event for event in trace.events if event.kind is EventKind.HIT)
    woken = [event for event in trace.events if event.kind is EventKind.WOKEN][:1]
    assert contact.time == pytest.approx(0.5 + 1.0 / speed, abs=0.003)
    assert len(woken) == (density > 100.0)  # friction stops the soft ball, so no brick moves
    for first in woken:
        assert first.time < contact.time
        assert first.reason.startswith("ball would hit ")
    assert contact.reason.startswith("ball hits ")
    assert contact.reason.endswith(f" at {hypot(speed, 0.5 * GRAVITY / speed):.3g} m/s")  # it also falls
    assert "L4.2" in contact.reason


def test_what_a_hit_brings_down_lies_at_rest_and_only_the_others_are_proven_to_stand() -> None:
    hit = BALL.format(bearing=90.0, speed=8.0)
    trace = played(WALL.format(heading=0.0), f"{{at: 0.5 s, {hit}}}", "exact", SCENE.format(density=2000.0))
    fallen = {name for name, track in trace.tracks.items() if track.left_at is not None}
    assert trace.collapse is not None
    assert trace.collapse.by.startswith(("sunk ", "tilted "))
    lines = EventLines(all_names=True)
    told = [line for event in trace.events for line in lines.after(event)]
    assert any(f"fallen     {trace.collapse.brick} has {trace.collapse.by}" in line for line in told)
    resting = [line.split("at rest")[1].strip() for line in told if "at rest" in line]
    for line in resting:
        names, proof, _ = line.partition(", proven to stand")
        lie = fallen | {"ball"}
        assert set(names.split(", ")) <= lie or (proof and not lie.intersection(names.split(", ")))
    assert any("ball" in line for line in resting)
    assert any("proven" in line for line in resting)


# A flat face 50 mm wide and 20 mm high arrives at the middle of a plank 7.8 mm high. It covers this plank, and bricks
# of the courses above and below, which have a joint in the middle.


def with_kind(name: str, thickness: str) -> str:
    return f"brick: kapla\nfriction: 0.5\nbrick_types: {{{name}: {{size: [50 mm, 50 mm, {thickness}], mass: 60 g}}}}"


@pytest.mark.parametrize(
    ("brick", "thickness", "names"),
    [("shot", "20 mm", "L3.2, with L2.2, L2.3, L4.2 and L4.3"), ("slip", "4 mm", "L3.2")],
    ids=["shot", "slip"],
)
@pytest.mark.parametrize(("speed", "system"), [(1, "exact"), (3, "tuned"), (6, "exact"), (6, "stock"), (12, "tuned")])
def test_a_flat_face_hits_all_bricks_that_it_covers_and_the_one_before_its_centre_first(
    brick: str, thickness: str, names: str, speed: int, system: str
) -> None:
    throw = f"throw: {{at: L3.2, from: {{bearing: 90 deg, distance: 0.3 m}}, speed: {speed} m/s, brick: {brick}}}"
    scene = with_kind(brick, thickness)
    trace = played("- wall: {levels: 5, bricks: 3}", f"{{at: 0.5 s, {throw}}}", system, scene)
    (contact,) = (event.reason for event in trace.events if event.kind is EventKind.HIT)
    told, _, at = contact.rpartition(" at ")
    assert told == f"thrown-1 hits {names}"
    into_the_face = (at.partition(", ")[2] or at).partition(" m/s")[0]
    assert float(into_the_face) == pytest.approx(speed, rel=0.02)  # `stock` damps the flight


@pytest.mark.parametrize(("behind", "names"), [("0", "a, with b"), ("1", "a"), ("-1", "b")])
def test_a_brick_that_stands_a_millimetre_further_back_is_not_hit_first(behind: str, names: str) -> None:
    post = "at: [{x} mm, {y} mm, 58.8 mm], rotate: [0 deg, 90 deg, 0 deg]"
    posts = f"{{name: a, {post.format(x=-5, y=0)}}}, {{name: b, {post.format(x=5, y=behind)}}}"
    throw = "throw: {at: a, from: {bearing: -90 deg, distance: 0.3 m}, speed: 4 m/s, brick: shot}"
    trace = played(f"- bricks: [{posts}]", f"{{at: 0.5 s, {throw}}}", "exact", with_kind("shot", "20 mm"))
    (contact,) = (event.reason for event in trace.events if event.kind is EventKind.HIT)
    assert contact == f"thrown-1 hits {names} at 4.02 m/s"  # it also falls, at g x 75 ms / 2
