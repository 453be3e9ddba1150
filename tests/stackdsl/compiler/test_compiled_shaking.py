"""When and how the ground shakes, and the mistakes that can be made about it."""

from math import pi

import pytest

from stability.dynamics.ground_motion import SineCourse, TabulatedCourse
from stackdsl.timeline import ShakeAction, Timeline
from tests.scenes import mistakes_of, timeline_of

BUILD = "- column: {levels: 3}\n  every: 1 s"
SINE = "acceleration: 2 m/s2, frequency: 3 Hz, for: 1.5 s"


def shaking(shake: str, rest: str = "") -> tuple[Timeline, ShakeAction]:
    timeline = timeline_of(BUILD, f"world: {{shake: {{{shake}}}}}\n{rest}")
    (found,) = (action for action in timeline.actions if isinstance(action, ShakeAction))
    return timeline, found


def test_shaking_begins_after_the_build_and_the_watch_after_shaking() -> None:
    timeline, shake = shaking(SINE)
    assert (shake.time, shake.motion.begins) == (2.0, 2.0)
    assert shake.motion.course == SineCourse(2.0, 3.0, 1.5)
    assert timeline.actions[-1] is shake
    assert timeline.end == pytest.approx(2.0 + 1.5 + timeline.hold)


@pytest.mark.parametrize(
    ("when", "time"),
    [("at: 0.5 s", 0.5), ("after: level 2 + 0.3 s", 1.3), ("after: impact 1", 4.0), ("after: brick L1.1", 0.0)],
)
def test_shaking_may_begin_at_a_time_or_after_an_event(when: str, time: float) -> None:
    push = "impacts: [{after: built + 2 s, push: {brick: L3.1, impulse: [1 mN*s, 0 N*s, 0 N*s]}}]"
    timeline, shake = shaking(f"{SINE}, {when}", push)
    assert shake.time == pytest.approx(time)
    assert list(timeline.actions) == sorted(timeline.actions, key=lambda action: action.time)


def test_an_amplitude_is_the_way_to_either_side() -> None:
    _, shake = shaking("amplitude: 10 mm, frequency: 3 Hz, for: 1.5 s")
    course = shake.motion.course
    assert isinstance(course, SineCourse)
    assert course.most == pytest.approx(0.01 * (6.0 * pi) ** 2)


def test_a_table_begins_with_its_first_row_and_along_its_bearing() -> None:
    _, shake = shaking("bearing: 90 deg, table: [[1 s, 0 m/s2], [2 s, -3 m/s2], [2 s, 4 m/s2], [3 s, 0 m/s2]]")
    assert shake.time == shake.motion.begins == 3.0
    assert shake.motion.course == TabulatedCourse(((0.0, 0.0), (1.0, -3.0), (1.0, 4.0), (2.0, 0.0)))
    assert shake.motion.direction_W == (0.0, 1.0, 0.0)


@pytest.mark.parametrize(
    ("shake", "code", "words", "hint"),
    [
        ("bearing: 0 deg", "SD108", "acceleration, amplitude, table", "add one"),
        (f"{SINE}, amplitude: 3 mm", "SD108", "acceleration and amplitude", "keep one"),
        ("acceleration: 2 m/s2, for: 1 s", "SD102", "`frequency` is missing", "frequency: 2 Hz"),
        ("amplitude: 2 mm, frequency: 1 Hz", "SD102", "`for` is missing", "for: 2 s"),
        ("acceleration: 2 m/s2, frequency: 0 Hz, for: 1 s", "SD104", "not greater than zero", "greater than zero"),
        ("acceleration: 2 m/s2, frequency: 1 kHz, for: 1 s", "SD106", "'kHz' is not a unit", "Hz"),
        ("acceleration: 2 m/s2, frequency: 200 Hz, for: 1 s", "SD104", "out of range", "at most 100 Hz"),
        ("acceleration: 2, frequency: 2 Hz, for: 1 s", "SD105", "has no unit", "m/s2"),
        ("acceleration: 2 m/s, frequency: 2 Hz, for: 1 s", "SD106", "'m/s' is not a unit of", "m/s2"),
        ("acceleration: 2 N, frequency: 2 Hz, for: 1 s", "SD106", "'N' is not a unit of", "m/s2"),
        ("amplitude: 1 m, frequency: 20 Hz, for: 1 s", "SD104", "is 1.579e+04 m/s2", "reduce"),
        (f"{SINE}, strength: 3", "SD101", "unknown key 'strength'", ""),
        (f"{SINE}, at: 1 s, after: built", "SD108", "exclude each other", "remove one"),
        (f"{SINE}, after: level 7", "SD205", "the ground waits for level 7", "level 1 to level 3"),
        (f"{SINE}, after: impact 1", "SD205", "the ground waits for impact 1", "another event"),
        ("table: [[0 s, 1 m/s2]]", "SD104", "1 item", "write 2 to"),
        ("table: [[0 s, 1 m/s2], [0 s, 2 m/s2]]", "SD104", "have the same time", "a later time"),
        ("table: [[0 s, 1 m/s2], [2 s, 2 m/s2], [1 s, 0 m/s2]]", "SD104", "row 3 of the table", "sort the rows"),
        ("table: [[0 s, 1 m/s2], [2 s, 0 m/s2]], frequency: 2 Hz", "SD108", "applies to a sine", "remove one"),
        ("table: [[0 s, 1 mm], [2 s, 0 m/s2]]", "SD106", "'mm' is not a unit", "m/s2"),
    ],
)  # fmt: skip
def test_impossible_shaking_has_a_diagnostic_at_its_place(shake: str, code: str, words: str, hint: str) -> None:
    (mistake,) = mistakes_of(BUILD, f"world: {{shake: {{{shake}}}}}")
    assert mistake.code == code
    assert words in mistake.message
    assert hint in mistake.hint
    assert mistake.span.line == 5
