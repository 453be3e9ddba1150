"""What a snapshot locks of bricks that are pulled out, hit or pushed."""

from dataclasses import replace
from math import nan

import pytest

from stackdsl.goldens.comparison import compare
from stackdsl.goldens.file_format import canonical_text, document
from stackdsl.goldens.snapshot import UNCLEAR, Pushing, Removing, Snapshot, take
from stackdsl.timeline import Arrival, Placement, PushAction
from stackdsl.trace import BrickState, BrickTrack, Collapse, Event, EventKind, Trace
from tests.stackdsl.goldens.towers import FALL, IDENTITY, STAMP, THRESHOLD, WORLD, states, taken, tower, track


def pulled_out() -> Trace:
    """The tower without its topmost plank, which was pulled out after 5 s."""
    trace = tower(track("L3.1", 3, BrickState.REMOVED, shift=nan))
    return replace(trace, events=(*trace.events, Event(5.0, EventKind.REMOVED, ("L3.1",))))


@pytest.mark.parametrize("proven", [True, False])
def test_a_brick_that_was_pulled_out_is_locked_with_its_time_and_without_a_place(proven: bool) -> None:
    snapshot = taken(pulled_out(), proven)
    assert snapshot.events[-1] == Removing(5.0, ("L3.1",))
    last = snapshot.bricks["L3.1"]
    assert (last.state, last.at_mm, last.rests_on) == ("removed", None, None)


def test_a_removed_brick_is_not_locked_as_standing() -> None:
    snapshot = taken(pulled_out())
    assert (snapshot.verdict, snapshot.height_mm, snapshot.levels_standing) == ("stands", 16.0, 2)


def test_the_text_of_a_removal_is_one_line() -> None:
    assert '    {"time_s": 5.0, "removed": ["L3.1"]}\n' in canonical_text(taken(pulled_out()))


def test_a_brick_pulled_out_at_another_time_or_not_at_all_is_a_difference() -> None:
    trace = pulled_out()
    later = replace(trace, events=(*trace.events[:-1], Event(6.0, EventKind.REMOVED, ("L3.1",))))
    never = replace(trace, events=trace.events[:-1])
    expected = document(taken(trace))
    assert compare(expected, taken(trace)) == ()
    assert [each.quantity for other in (later, never) for each in compare(expected, taken(other))] == [
        "pulled out at"
    ] * 2


# --- hits -------------------------------------------------------------------------------------------------------------


def struck(name: str, level: int, shift: float, sunk: float = 0.0, state: BrickState = BrickState.FROZEN) -> BrickTrack:
    """A plank of a tower that was hit, which shifted and sank by so much [m]."""
    return replace(track(name, level, state, shift), sunk=sunk)


def hit_tower(*changed: BrickTrack, collapse: Collapse | None = None) -> Trace:
    """A missile comes at 3 s; what is not among `changed` it did not move."""
    missile = replace(track("shot", 0, BrickState.THROWN), shift=0.0)
    still = [struck(name, level, 0.0) for level, name in enumerate(("L1.1", "L2.1", "L3.1"), start=1)]
    trace = tower(*still, *changed, missile, collapse=collapse)
    return replace(trace, events=(*trace.events, Event(3.0, EventKind.PLACED, ("shot",))))


def test_a_hit_that_moves_nothing_changes_no_locked_value() -> None:
    snapshot = taken(hit_tower())
    assert states(snapshot) == {"shot": "thrown", "L1.1": "frozen", "L2.1": "frozen", "L3.1": "frozen"}
    assert snapshot.bricks["L2.1"].at_mm == (0.0, 0.0, 12.0)
    assert snapshot.bricks["L2.1"].rests_on == {"L1.1": 1.0}
    assert (snapshot.bricks["shot"].at_mm, snapshot.bricks["shot"].rests_on) == (None, None)
    assert (snapshot.height_mm, snapshot.levels_standing) == (24.0, 3)


@pytest.mark.parametrize(
    ("shift", "sunk", "state", "expected"),
    [
        (0.25, 0.0, BrickState.FROZEN, "frozen"),
        (0.5, 0.0, BrickState.FROZEN, UNCLEAR),  # half of the threshold: another engine may shift it beyond
        (1.5, 0.0, BrickState.DISPLACED, UNCLEAR),
        (3.5, 0.0, BrickState.DISPLACED, "displaced"),
        (3.5, 0.5, BrickState.DISPLACED, UNCLEAR),  # it might have sunk
        (9.0, 1.5, BrickState.FALLEN, UNCLEAR),
        (9.0, 3.5, BrickState.FALLEN, "fallen"),
    ],
)
def test_the_effect_of_a_hit_on_a_brick_is_locked_if_it_is_clear(
    shift: float, sunk: float, state: BrickState, expected: str
) -> None:
    moved = struck("L3.1", 3, shift * THRESHOLD, sunk * THRESHOLD, state)
    snapshot = taken(hit_tower(moved))
    assert snapshot.bricks["L3.1"].state == expected
    assert snapshot.bricks["L3.1"].at_mm in (None, (UNCLEAR, UNCLEAR, UNCLEAR))
    assert snapshot.bricks["L2.1"].at_mm == (0.0, 0.0, 12.0)
    assert {brick.rests_on for brick in snapshot.bricks.values()} == {None}


def test_a_hit_after_a_collapse_changes_nothing_of_what_was_told_before_it() -> None:
    fallen = track("L3.1", 3, BrickState.FALLEN, 5.0 * THRESHOLD)
    margins = [event.margin_mm for event in taken(hit_tower(fallen, collapse=FALL)).placings]
    assert margins == [12.0, 12.0, None, None]  # neither of what brought it down nor of what came later


def test_a_push_is_locked_with_its_time() -> None:
    trace = tower()
    pushed = taken(replace(trace, events=(*trace.events, Event(3.0, EventKind.PUSHED, ("L3.1",)))))
    assert pushed.events[-1] == Pushing(3.0, ("L3.1",))
    assert compare(document(pushed), pushed) == ()
    later = replace(pushed, events=(*pushed.events[:-1], Pushing(3.5, ("L3.1",))))
    assert [found.quantity for found in compare(document(pushed), later)] == ["pushed at"]
    twice = replace(pushed, events=(*pushed.events, Pushing(4.0, ("L3.1",))))
    assert [found.expected for found in compare(document(pushed), twice)] == ["none"]


def test_a_throw_and_a_push_are_locked_as_the_author_wrote_them() -> None:
    shot = hit_tower().tracks["shot"]
    trace = hit_tower()
    trace = replace(trace, events=(*trace.events, Event(4.0, EventKind.PUSHED, ("L3.1",))))

    def snapshot(speed: float, impulse: float) -> Snapshot:
        thrown = Placement(3.0, shot.brick, 0, shot.placed, Arrival.THROWN, (0.0, speed, 0.5))
        return take(trace, WORLD, IDENTITY, STAMP, True, (thrown, PushAction(4.0, "L3.1", (impulse, 0.0, 0.0))))

    expected = document(snapshot(4.0, 0.01))
    assert compare(expected, snapshot(4.0, 0.01)) == ()
    told = [
        (found.subject, found.quantity, found.expected, found.got) for found in compare(expected, snapshot(8.0, 0.02))
    ]
    assert ("shot", "y velocity when thrown", "4000.000 mm/s", "8000.000 mm/s") in told
    assert ("L3.1", "x impulse of the push", "10.000000 mN*s", "20.000000 mN*s") in told
    assert len(told) == 2
    assert compare(document(taken(trace)), snapshot(8.0, 0.02)) == ()  # a file of an earlier version has neither
