"""Life cycle of bricks: observers receive each event once, in a fixed order."""

from collections.abc import Collection
from dataclasses import dataclass, field

import pytest

from stability.model import BodyId, BodyState, Pose
from stability.stabilizers.protocol import BrickObserver, Observers
from stability.stabilizers.rest import Refusals, RestLimits, Stillness

EVENTS = ("set_down", "frozen", "woken", "removed")
STEP = 0.01  # [s], longer than the dwell of a brick before its judgement


@dataclass
class Diary(BrickObserver):
    """Records the events of each observer."""

    name: str
    pages: list[tuple[str, str, tuple[BodyId, ...]]] = field(default_factory=list)

    def set_down(self, bricks: Collection[BodyId]) -> None:
        self.pages.append((self.name, "set_down", tuple(bricks)))

    def frozen(self, bricks: Collection[BodyId]) -> None:
        self.pages.append((self.name, "frozen", tuple(bricks)))

    def woken(self, bricks: Collection[BodyId]) -> None:
        self.pages.append((self.name, "woken", tuple(bricks)))

    def removed(self, bricks: Collection[BodyId]) -> None:
        self.pages.append((self.name, "removed", tuple(bricks)))


@pytest.mark.parametrize("event", EVENTS)
def test_all_observers_hear_an_event_once_in_the_order_in_which_they_are_given(event: str) -> None:
    first = Diary("first")
    told = Observers((first, Observers((Diary("second", first.pages),)), Diary("third", first.pages)))
    getattr(told, event)(["a", "b"])
    assert first.pages == [(name, event, ("a", "b")) for name in ("first", "second", "third")]


@pytest.mark.parametrize("event", EVENTS)
def test_an_observer_need_not_react(event: str) -> None:
    getattr(BrickObserver(), event)(["a"])


def resting(stillness: Stillness, start: float, duration: float) -> bool:
    """Whether brick `a` may be judged when it has been slow for so long [s]."""
    stillness.follow(start, {"a": BodyState(Pose((0.0, 0.0, 0.0)))})
    stillness.follow(start + duration, {"a": BodyState(Pose((0.0, 0.0, 0.0)))})
    return stillness.may_be_judged("a", start + duration)


def test_a_brick_that_is_set_down_may_be_judged_at_once_and_one_that_appears_may_not() -> None:
    stillness = Stillness(lambda _: RestLimits())
    assert not resting(stillness, 0.0, 0.0)
    stillness.set_down(["a"])
    assert resting(stillness, 0.0, 0.0)


def test_a_woken_brick_waits_for_the_hold_off_and_a_new_one_under_its_name_does_not() -> None:
    stillness = Stillness(lambda _: RestLimits())
    stillness.frozen(["a"])
    stillness.woken(["a"])
    assert not resting(stillness, 1.0, STEP)
    stillness.removed(["a"])
    assert resting(stillness, 2.0, STEP)


@pytest.mark.parametrize(
    ("event", "bricks", "news"),
    [
        ("frozen", ["other"], True),
        ("woken", ["other"], True),
        ("removed", ["other"], True),
        ("removed", ["a"], True),
        ("set_down", ["other"], False),
        ("woken", [], False),  # judged, and nothing came of it
    ],
)
def test_a_refused_brick_is_news_again_as_soon_as_other_bricks_stand_or_not(
    event: str, bricks: list[BodyId], news: bool
) -> None:
    pose = Pose((0.0, 0.0, 0.0))
    refusals = Refusals(lambda _: RestLimits())
    refusals.refuse([("a", pose)], 0.0)
    assert not refusals.has_changed("a", pose, 0.008, STEP)
    getattr(refusals, event)(bricks)
    assert refusals.has_changed("a", pose, 0.008, STEP) is news
