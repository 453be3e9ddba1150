"""What is made for a structure is looked at more seldom by the collector of garbage, and only meanwhile."""

import gc
from collections.abc import Iterator
from contextlib import suppress

import pytest

from stability.garbage import SELDOM, rarely_collected


@pytest.fixture(autouse=True)
def threshold() -> Iterator[None]:
    before = gc.get_threshold()
    yield
    gc.set_threshold(*before)


def test_the_collector_looks_more_seldom_only_meanwhile() -> None:
    gc.set_threshold(700, 7, 9)
    with rarely_collected():
        assert gc.get_threshold() == (SELDOM, 7, 9)
        with rarely_collected():
            pass
        assert gc.get_threshold() == (SELDOM, 7, 9)
    assert gc.get_threshold() == (700, 7, 9)


def test_a_mistake_meanwhile_changes_nothing_of_that() -> None:
    gc.set_threshold(700, 7, 9)
    with suppress(KeyError), rarely_collected():
        raise KeyError
    assert gc.get_threshold() == (700, 7, 9)


@pytest.mark.parametrize("own", [0, SELDOM + 1])
def test_whoever_has_it_look_as_seldom_or_not_at_all_is_left_so(own: int) -> None:
    gc.set_threshold(own, 7, 9)
    with rarely_collected():
        assert gc.get_threshold() == (own, 7, 9)
