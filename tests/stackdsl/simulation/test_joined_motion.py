"""Joined bricks that move on `exact`: what holds moves as one body, and joints open that do not bear their loads.

All references are closed forms, or the run of one brick with the shape of the joined ones.
"""

from functools import cache
from math import cos, radians, sin, sqrt

import numpy as np
import pytest

from stability.geometry.rows import Array
from stability.model import BodyId
from stackdsl.simulation.recording import Recorder, Recording
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.simulation.worlds import settings_for
from stackdsl.timeline import Timeline
from stackdsl.trace import BrickState, EventKind, Trace
from tests.scenes import compiled

G = 9.81  # [m/s2]
STRONG = "bond: {tension: 10 MPa, cohesion: 40 MPa}"
ON_DRY_GROUND = f"of: stone, {STRONG}"


def timeline_of(text: str) -> Timeline:
    cases, mistakes = compiled(text)
    assert mistakes == []
    return cases[0].timeline


@cache  # a run repeats to the last bit, so one serves all tests
def played(text: str) -> tuple[Trace, Recording]:
    recorder = Recorder()
    trace = play(timeline_of(text), SYSTEMS["exact"], recorder=recorder)
    assert trace.energy is not None
    assert trace.energy.risen <= 1e-3 * trace.energy.of_what_moved
    return trace, recorder.recording()


def place(recording: Recording, brick: BodyId, time: float) -> Array:
    """The centre of mass of a brick [m]."""
    position: Array = recording.at(time).positions[recording.names.index(brick)]
    return position


def mean_place(recording: Recording, bricks: list[BodyId], time: float) -> Array:
    mean: Array = np.mean([place(recording, brick, time) for brick in bricks], axis=0)
    return mean


def woken(trace: Trace) -> set[BodyId]:
    return {name for event in trace.events if event.kind is EventKind.WOKEN for name in event.bricks}


# --- toppling and falling ---------------------------------------------------------------------------------------------

ON_AN_EDGE = """
scenario: edge
brick_types:
  bar: {{size: [{length} mm, 20 mm, 20 mm], mass: {mass} kg}}
  base: {{size: [200 mm, 100 mm, 50 mm], mass: 2 kg}}
brick: bar
{joints}
build:
  - bricks: [{{brick: base, on: ground, name: base}}]
    every: 1 s
  - bricks: [{bars}]
watch: 0.3 s
expect: [{{collapses: any}}]
"""


def test_a_glued_pair_topples_over_an_edge_as_one_bar_of_its_length() -> None:
    glued = ON_AN_EDGE.format(
        length=100,
        mass=0.04,
        joints=f"joints: [{{between: [b, c], {STRONG}}}]",
        bars="{at: [52 mm, 0 mm, 60 mm], name: b}, {at: [152 mm, 0 mm, 60 mm], name: c}",
    )
    one = ON_AN_EDGE.format(length=200, mass=0.08, joints="", bars="{at: [102 mm, 0 mm, 60 mm], name: a}")
    (trace, pair), (_, bar) = played(glued), played(one)
    assert woken(trace) == {"b", "c"}
    for time in (1.1, 1.2, 1.3):
        fallen = 0.06 - place(bar, "a", time)
        assert np.abs(mean_place(pair, ["b", "c"], time) - place(bar, "a", time)).max() < 1e-3 * abs(fallen[2])
        assert np.linalg.norm(place(pair, "b", time) - place(pair, "c", time)) == pytest.approx(0.1, rel=1e-9)


def test_names_and_order_change_nothing() -> None:
    first, second = "{{at: [52 mm, 0 mm, 60 mm], name: {}}}", "{{at: [152 mm, 0 mm, 60 mm], name: {}}}"
    written = [f"{first.format('b')}, {second.format('c')}", f"{second.format('b')}, {first.format('c')}"]
    joints = f"joints: [{{between: [b, c], {STRONG}}}]"
    (_, one), (_, other) = (
        played(ON_AN_EDGE.format(length=100, mass=0.04, joints=joints, bars=bars)) for bars in written
    )
    for time in (1.1, 1.2, 1.3):
        for brick, same in (("b", "c"), ("c", "b")):
            assert np.allclose(place(one, brick, time), place(other, same, time), rtol=0.0, atol=1e-7)


HANGING = """
scenario: hanging
brick_types:
  pillar: {{size: [50 mm, 100 mm, 500 mm], mass: 2 kg}}
  beam: {{size: [500 mm, 100 mm, 50 mm], mass: 3 kg}}
  small: {{size: [60 mm, 40 mm, 20 mm], mass: 0.1 kg}}
brick: small
joints:
  - {{between: [beam, small], pull: {pull} N}}
  - {{between: [a, b], bond: {{tension: {tension} Pa, cohesion: 1 MPa}}}}
build:
  - bricks:
      - {{brick: pillar, at: [-200 mm, 0 mm, 250 mm], name: p}}
      - {{brick: pillar, at: [200 mm, 0 mm, 250 mm], name: q}}
    every: 0.5 s
  - bricks: [{{brick: beam, at: [0 mm, 0 mm, 525 mm], name: top}}]
    every: 0.5 s
  - bricks: [{{at: [0 mm, 0 mm, 490 mm], name: a}}]
    every: 0.5 s
  - bricks: [{{at: [0 mm, 0 mm, 470 mm], name: b}}]
watch: 0.5 s
expect: [{{collapses: any}}]
"""


def test_a_magnet_that_is_too_weak_lets_its_brick_fall_freely() -> None:
    # The magnet bears 4 F: more than one brick of 0.1 kg weighs, and less than two.
    trace, recording = played(HANGING.format(pull=0.4, tension=1e6))
    assert {name for name, track in trace.tracks.items() if track.state is BrickState.FALLEN} == {"a", "b"}
    landing = sqrt(2.0 * 0.46 / G)
    for time in (0.1, 0.2, 0.9 * landing):
        assert place(recording, "b", 2.0 + time)[2] == pytest.approx(0.47 - 0.5 * G * time * time, abs=1e-9)
    # Together, as one body.
    assert np.allclose(place(recording, "a", 9.0) - place(recording, "b", 9.0), (0.0, 0.0, 0.02), atol=1e-4)


def test_only_the_glue_opens_if_it_is_weaker_than_the_magnet() -> None:
    area = 0.06 * 0.04
    for tension, fallen in ((0.1 * G / area * 0.999, {"b"}), (0.1 * G / area * 1.001, set[str]())):
        trace, _ = played(HANGING.format(pull=10, tension=tension))
        assert {name for name, track in trace.tracks.items() if track.state is BrickState.FALLEN} == fallen


# --- hits -------------------------------------------------------------------------------------------------------------

PIER = """
scenario: pier
brick_types:
  stone: {{size: [200 mm, 200 mm, {height} mm], mass: {mass} kg}}
brick: stone
{joints}
build:
  - column: {{levels: {levels}, step: 0 mm{turn}}}
impacts:
  - push: {{brick: L{levels}.1, impulse: [{x} N*s, {y} N*s, 0 N*s], point: [0 mm, 0 mm, {point} mm]}}
    at: 10 s
watch: 1.5 s
expect: [{{stands: all}}]
"""
BASE, HEIGHT, MASS = 0.2, 0.6, 48.0


def pier(impulse: float, joints: str, levels: int = 6, angle: float = 0.0) -> str:
    height = 600 // levels
    return PIER.format(
        height=height,
        mass=MASS / levels,
        joints=f"joints: [{{{joints}}}]" if joints else "",
        levels=levels,
        turn=f", heading: {angle} deg" if angle else "",
        x=impulse * cos(radians(angle)),
        y=impulse * sin(radians(angle)),
        point=550 - (600 - 0.5 * height),
    )


def test_a_strong_pier_that_is_pushed_rocks_as_one_block() -> None:
    # Housner 1963: the push turns the block about its edge; each landing loses part of the speed.
    (_, joined), (_, one) = played(pier(15.0, ON_DRY_GROUND)), played(pier(15.0, "", levels=1))
    names = [f"L{level}.1" for level in range(1, 7)]
    about_edge = MASS * (BASE**2 + HEIGHT**2) / 3.0
    speed, lever = 15.0 * 0.55 / about_edge, 0.5 * HEIGHT
    assert mean_place(joined, names, 10.01)[0] == pytest.approx(lever * speed * 0.01, rel=0.05)
    for time in (0.1, 0.2, 0.3, 0.4):
        shift = place(one, "L1.1", 10.0 + time) - (0.0, 0.0, lever)
        apart = mean_place(joined, names, 10.0 + time) - place(one, "L1.1", 10.0 + time)
        assert np.linalg.norm(apart) < 3e-3 * np.linalg.norm(shift)


def test_a_pushed_pier_opens_at_its_base_beyond_the_moment_that_its_mortar_bears() -> None:
    # Tension over half of the width with lever b / 2, and the weight: t b^3 / 2 + W b / 2 = h J / d.
    impulse = 15.0
    duration = settings_for(timeline_of(pier(impulse, STRONG)), SYSTEMS["exact"]).time_step
    tension = (0.55 * impulse / duration - 0.5 * BASE * MASS * G) / (0.5 * BASE**3)
    for share, moves in ((1.001, False), (0.999, True)):
        joints = f"bond: {{tension: {share * tension} Pa, cohesion: {10.0 * tension} Pa}}"
        trace, _ = played(pier(impulse, joints))
        assert ("L1.1" in woken(trace)) == moves


def test_a_pier_without_strength_is_dry() -> None:
    (_, weightless), (_, dry) = played(pier(15.0, "pull: 0 N")), played(pier(15.0, ""))
    for time in (0.05, 0.1, 0.2):
        for brick in ("L1.1", "L5.1", "L6.1"):
            assert np.allclose(place(weightless, brick, 10.0 + time), place(dry, brick, 10.0 + time), atol=1e-4)


def test_a_turned_pier_moves_alike() -> None:
    names = [f"L{level}.1" for level in range(1, 7)]
    (_, straight), (_, turned) = played(pier(15.0, ON_DRY_GROUND)), played(pier(15.0, ON_DRY_GROUND, angle=30.0))
    x, _, z = mean_place(straight, names, 10.2)
    assert x > 0.03
    expected = (x * cos(radians(30.0)), x * sin(radians(30.0)), z)
    assert np.allclose(mean_place(turned, names, 10.2), expected, atol=5e-3 * x)


IN_THE_AIR = """
scenario: air
brick_types:
  block: {{size: [100 mm, 40 mm, 40 mm], mass: 0.2 kg}}
brick: block
joints: [{{between: [a, b], bond: {{tension: {tension} Pa, cohesion: 10 MPa}}}}]
build:
  - bricks: [{{at: [0 mm, 0 mm, 2 m], name: a}}, {{at: [100 mm, 0 mm, 2 m], name: b}}]
impacts:
  - push: {{brick: a, impulse: [-0.2 N*s, 0 N*s, 0 N*s]}}
    at: 0.05 s
watch: 0.5 s
expect: [{{collapses: any}}]
"""


def test_a_push_in_the_air_parts_a_pair_whose_joint_does_not_bear_its_half_and_passes_on_its_strength() -> None:
    duration = settings_for(timeline_of(IN_THE_AIR.format(tension=1.0)), SYSTEMS["exact"]).time_step
    tension = 0.5 * 0.2 / duration / 0.04**2  # to take along the half of the mass that is not pushed
    # The joint passes on its strength for the duration of the push, also if it opens.
    for share in (1.001, 0.999, 0.5):
        passed = 0.5 * min(share, 1.0)
        _, recording = played(IN_THE_AIR.format(tension=share * tension))
        for time in (0.1, 0.3):
            after = time - 0.05
            late = 0.0 if share > 1.0 else 0.5 * duration  # until the mean of a force
            for brick, place_then in (
                ("a", -after + passed * (after - late)),
                ("b", 0.1 - passed * (after - late)),
            ):
                x, _, z = place(recording, brick, time)
                assert x == pytest.approx(place_then, abs=1e-6)
                assert z == pytest.approx(2.0 - 0.5 * G * time * time, abs=1e-6)


LEGO = """
scenario: lego
brick_types:
  shot: {{size: [60 mm, 20 mm, 20 mm], mass: 0.02 kg}}
  lego: {{size: [32 mm, 16 mm, {height} mm], mass: {mass} g}}
brick: lego
{joints}
build:
  - column: {{levels: {levels}, step: 0 mm}}
impacts:
  - throw: {{at: {target}, from: {{bearing: 90 deg, distance: 30 mm}}, speed: 5 m/s, brick: shot}}
    at: 3 s
watch: 1 s
expect: [{{stands: all}}]
"""


def test_a_studded_tower_that_is_hit_moves_as_one_brick() -> None:
    studs = "joints: [{of: lego, studs: {pitch: 8 mm, pull: 1 kN, shear: 1 kN}}]"
    (trace, tower) = played(LEGO.format(height=9.6, mass=2.3, joints=studs, levels=7, target="L4.1"))
    (_, brick) = played(LEGO.format(height=67.2, mass=16.1, joints="", levels=1, target="L1.1"))
    names = [f"L{level}.1" for level in range(1, 8)]
    assert EventKind.OPENED not in {event.kind for event in trace.events}
    for time in (3.02, 3.05, 3.1):
        shift = place(brick, "L1.1", time) - (0.0, 0.0, 0.0336)
        assert np.linalg.norm(shift) > 0.01
        assert np.allclose(
            mean_place(tower, names, time), place(brick, "L1.1", time), atol=3e-3 * np.linalg.norm(shift)
        )
        assert np.linalg.norm(place(tower, "L7.1", time) - place(tower, "L1.1", time)) == pytest.approx(
            0.0576, rel=1e-9
        )


def test_studs_that_a_hit_opens_are_named() -> None:
    studs = "joints: [{of: lego, studs: {pitch: 8 mm, pull: 1 N, shear: 3 N}}]"
    trace, _ = played(LEGO.format(height=9.6, mass=2.3, joints=studs, levels=8, target="L6.1"))
    opened = [event for event in trace.events if event.kind is EventKind.OPENED]
    assert opened
    assert all(event.reason.startswith("joint") for event in opened)
    assert {name for event in opened for name in event.bricks} <= {f"L{level}.1" for level in range(1, 9)}


def test_the_rest_of_a_body_stays_one_body_after_a_joint_opens() -> None:
    # A row of three: the push on its end takes the middle along by strong glue, and leaves the other end behind.
    row = IN_THE_AIR.format(tension=1e-3)
    row = row.replace("build:", "  - {between: [b, c], bond: {tension: 1 MPa, cohesion: 10 MPa}}\nbuild:")
    row = (
        row.replace("joints: [{", "joints:\n  - {")
        .replace("}}]", "}}", 1)
        .replace("name: b}]", "name: b}, {at: [200 mm, 0 mm, 2 m], name: c}]")
    )
    row = row.replace("brick: a, impulse: [-0.2", "brick: c, impulse: [0.2")
    _, recording = played(row)
    for brick, start, speed in (("a", 0.0, 0.0), ("b", 0.1, 0.5), ("c", 0.2, 0.5)):
        assert place(recording, brick, 0.3)[0] == pytest.approx(start + speed * 0.25, abs=1e-6)


# --- ductile joints ---------------------------------------------------------------------------------------------------


def test_a_ductile_magnet_slows_the_fall_of_its_brick_until_they_are_apart() -> None:
    # It bears 4 F of the weight W of two bricks, which fall with the difference for 10 mm, and then freely.
    share, mass = 1.0 / 1.2, 0.2
    hanging = HANGING.replace("pull: {pull} N", "pull: {{force: {pull} N, ductile: 10 mm}}")
    _, recording = played(hanging.format(pull=0.25 * share * mass * G, tension=1e6))
    slow = (1.0 - share) * G
    parting = sqrt(2.0 * 0.01 / slow)
    for time in (0.5 * parting, 0.9 * parting, parting + 0.05, parting + 0.1):
        free = max(0.0, time - parting)
        fallen = 0.5 * slow * (time - free) ** 2 + slow * parting * free + 0.5 * G * free * free
        assert 0.49 - place(recording, "a", 2.0 + time)[2] == pytest.approx(fallen, rel=2e-2 if free else 1e-4)


PUSHED = """
scenario: pushed
brick_types:
  slab: {{size: [200 mm, 200 mm, 20 mm], mass: 2 kg}}
brick: slab
joints: [{{{joint}}}]
world: {{ground: {{friction: 0.3}}}}
build:
  - bricks: [{{at: [0 mm, 0 mm, 10 mm], name: a}}]
impacts:
  - push: {{brick: a, impulse: [{impulse} N*s, 0 N*s, 0 N*s]}}
    at: 1 s
watch: 1 s
expect: [{{stands: all}}]
"""


def test_a_glued_slab_that_is_pushed_is_slowed_by_its_cohesion_and_friction() -> None:
    # At the height of its centre, low: cohesion c A and friction mu W against the impulse J; v0 = J / m.
    cohesion, impulse, mass = 100.0, 1.0, 2.0
    deceleration = cohesion * 0.2**2 / mass + 0.3 * G
    stop = (impulse / mass) ** 2 / 2.0 / deceleration
    glue = f"bond: {{tension: 1 kPa, cohesion: {cohesion} Pa, ductile: 50 mm}}"
    trace, recording = played(PUSHED.format(joint=glue, impulse=impulse))
    assert place(recording, "a", 1.9)[0] == pytest.approx(stop, rel=5e-3)
    assert trace.assembly is not None
    assert trace.assembly.problem().has_joints  # it holds where it has come to rest
    assert EventKind.OPENED not in {event.kind for event in trace.events}


def test_glue_that_is_ductile_over_less_than_the_slide_opens_on_the_way() -> None:
    # Dry from 10 mm on: the cohesion has taken its work c A x out of the motion.
    cohesion, impulse, mass, ductile = 100.0, 1.0, 2.0, 0.01
    left = 0.5 * impulse**2 / mass - (cohesion * 0.2**2 + 0.3 * mass * G) * ductile
    glue = f"bond: {{tension: 1 kPa, cohesion: {cohesion} Pa, ductile: {1000.0 * ductile} mm}}"
    trace, recording = played(PUSHED.format(joint=glue, impulse=impulse))
    assert place(recording, "a", 1.9)[0] == pytest.approx(ductile + left / (0.3 * mass * G), rel=1e-2)
    assert trace.assembly is not None
    assert not trace.assembly.problem().has_joints
    assert [event.reason for event in trace.events if event.kind is EventKind.OPENED]


def test_a_push_within_the_strength_of_ductile_glue_moves_nothing() -> None:
    duration = settings_for(timeline_of(PUSHED.format(joint="pull: 1 N", impulse=1.0)), SYSTEMS["exact"]).time_step
    glue = "bond: {tension: 1 MPa, cohesion: 1 MPa, ductile: 50 mm}"
    impulse = 0.99 * (1e6 * 0.2**2 + 0.3 * 2.0 * G) * duration
    _, recording = played(PUSHED.format(joint=glue, impulse=impulse))
    assert place(recording, "a", 1.9)[0] == pytest.approx(0.0, abs=1e-9)


# --- hands ------------------------------------------------------------------------------------------------------------

IN_A_HAND = """
scenario: hand
brick_types:
  block: {{size: [100 mm, 100 mm, 50 mm], mass: 1 kg}}
brick: block
joints: [{{between: [a, b], bond: {{tension: {tension} Pa, cohesion: 1 MPa}}}}]
build:
  - bricks: [{{at: [0 mm, 0 mm, 25 mm], name: a}}, {{at: [0 mm, 0 mm, 75 mm], name: b}}]
impacts:
  - move: {{brick: b, by: [0 mm, 0 mm, 100 mm], speed: 300 mm/s, held: {held} s}}
    at: 1 s
watch: 0.5 s
expect: [{{collapses: any}}]
"""


def test_a_lifted_brick_takes_along_what_its_joint_bears_with_the_acceleration_of_the_hand() -> None:
    # Least jerk: v = 1.875 L / T, and the greatest acceleration 10 / sqrt(3) L / T^2.
    lasts = 1.875 * 0.1 / 0.3
    needed = 1.0 * (G + 10.0 / sqrt(3.0) * 0.1 / lasts**2) / 0.1**2
    for share, comes in ((1.005, True), (0.995, False)):
        trace, recording = played(IN_A_HAND.format(tension=share * needed, held=0.5))
        lifted = 1.0 + lasts + 0.4
        assert place(recording, "b", lifted) == pytest.approx((0.0, 0.0, 0.175), abs=1e-6)
        assert place(recording, "a", lifted)[2] == pytest.approx(0.125 if comes else 0.025, abs=1e-4)
        assert (EventKind.OPENED in {event.kind for event in trace.events}) != comes


def test_what_a_hand_releases_falls_as_one_body() -> None:
    lasts = 1.875 * 0.1 / 0.3
    for held in (0.0, 0.5):
        trace, recording = played(IN_A_HAND.format(tension=1e6, held=held))
        released, falling = 1.0 + lasts + held, 0.1
        for brick, height in (("a", 0.125), ("b", 0.175)):
            fallen = height - place(recording, brick, released + falling)[2]
            assert fallen == pytest.approx(0.5 * G * falling**2, rel=1e-2)
        assert place(recording, "b", 9.0)[2] == pytest.approx(0.075, abs=1e-4)
        assert trace.assembly is not None
        assert trace.assembly.problem().has_joints


def test_a_hand_that_holds_a_brick_holds_what_hangs_on_it() -> None:
    text = HANGING.format(pull=10, tension=1e6).replace("watch: 0.5 s", "watch: 0.3 s")
    for impacts, falls in (("", True), ("  - hold: {brick: a, for: 0.5 s}\n    at: 3 s\n", False)):
        cut = text.replace("watch:", f"impacts:\n{impacts}  - cut: {{between: [top, a]}}\n    at: 3.2 s\nwatch:")
        _, recording = played(cut)
        for brick, height in (("a", 0.49), ("b", 0.47)):
            at_3_4 = height - (0.5 * G * 0.2**2 if falls else 0.0)
            assert place(recording, brick, 3.4)[2] == pytest.approx(at_3_4, abs=2e-3)
            # Then both fall together.
            assert place(recording, "a", 9.0)[2] - place(recording, "b", 9.0)[2] == pytest.approx(0.02, abs=1e-3)


def test_a_brick_that_a_hand_brings_is_glued_where_it_is_released() -> None:
    text = IN_A_HAND.format(tension=1e6, held=0.0).replace("{at: [0 mm, 0 mm, 75 mm], name: b}]", "]")
    text = text[: text.index("impacts:")] + "  - bricks: [{at: [80 mm, 0 mm, 75 mm], name: b}]\n    place: by hand\n"
    text += "watch: 1 s\nexpect: [{collapses: any}]\n"
    trace, _ = played(text)
    assert trace.tracks["b"].state is BrickState.FROZEN
    assert trace.assembly is not None
    assert trace.assembly.problem().has_joints


# --- shaking ground and drops -----------------------------------------------------------------------------------------

SHAKEN = """
scenario: shaken
brick_types:
  stone: {{size: [200 mm, 200 mm, {height} mm], mass: {mass} kg}}
brick: stone
{joints}
build:
  - column: {{levels: {levels}, step: 0 mm}}
world: {{shake: {{acceleration: {acceleration} m/s2, frequency: 1 Hz, for: 1 s, at: 1 s}}}}
watch: 1 s
expect: [{{stands: all}}]
"""


def test_the_base_of_a_mortared_pier_opens_beyond_the_acceleration_that_it_bears() -> None:
    tension = 2000.0
    bears = (0.5 * tension * BASE**3 + 0.5 * MASS * G * BASE) / (0.5 * MASS * HEIGHT)
    joints = f"joints: [{{bond: {{tension: {tension} Pa, cohesion: 1 MPa}}}}]"
    for share, opens in ((0.999, False), (1.001, True)):
        shaken = SHAKEN.format(height=100, mass=MASS / 6, joints=joints, levels=6, acceleration=share * bears)
        trace, _ = played(shaken)
        reasons = [event.reason for event in trace.events if event.kind is EventKind.OPENED]
        assert any("L1.1 and ground" in reason for reason in reasons) == opens
        assert ("L1.1" in woken(trace)) == opens


def test_a_joined_pier_on_shaking_ground_rocks_as_one_block() -> None:
    strong = f"joints: [{{{ON_DRY_GROUND}}}]"
    _, joined = played(SHAKEN.format(height=100, mass=MASS / 6, joints=strong, levels=6, acceleration=4.0))
    _, one = played(SHAKEN.format(height=600, mass=MASS, joints="", levels=1, acceleration=4.0))
    names = [f"L{level}.1" for level in range(1, 7)]
    for time in (1.4, 1.8, 2.0):
        shift = place(one, "L1.1", time) - (0.0, 0.0, 0.5 * HEIGHT)
        assert np.linalg.norm(shift) > 0.01
        apart = mean_place(joined, names, time) - place(one, "L1.1", time)
        assert np.linalg.norm(apart) < 3e-3 * np.linalg.norm(shift)


def test_a_dropped_brick_has_no_joint_where_it_lands() -> None:
    text = """
scenario: dropped
brick_types:
  block: {size: [100 mm, 40 mm, 40 mm], mass: 0.2 kg}
brick: block
joints: [{between: [block, c], bond: {tension: 1 MPa, cohesion: 10 MPa}}]
build:
  - bricks: [{at: [0 mm, 0 mm, 20 mm], name: b}]
    every: 1 s
  - bricks: [{at: [60 mm, 0 mm, 70 mm], name: c, drop: true}]
watch: 1 s
expect: [{stands: all}]
"""
    overhanging, _ = played(text)
    assert overhanging.tracks["c"].rest.position_W[2] < 0.05  # glue would hold it, and without glue it tips over
    for written, is_joined in ((text, False), (text.replace("70 mm], name: c, drop: true", "60 mm], name: c"), True)):
        trace, _ = played(written.replace("60 mm, 0 mm", "0 mm, 0 mm"))
        assert trace.tracks["c"].rest.position_W[2] == pytest.approx(0.06, abs=1e-4)
        assert trace.assembly is not None
        assert trace.assembly.problem().has_joints == is_joined
