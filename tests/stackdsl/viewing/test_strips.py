"""A strip of pictures spreads over the motion, and shows flying bricks that are near."""

import re

import numpy as np
import pytest

from stackdsl.simulation.recording import COLUMNS, NUMBER, POSITION, TIME
from stackdsl.viewing.drawing import VIEWS
from stackdsl.viewing.pictures import picture, strip, times_of_motion
from tests.stackdsl.viewing.views import SLANT_TOWER, views_of

THROWN = """
    scenario: thrown
    build:
      - column: {levels: 4}
        every: 1 s
    impacts:
      - {after: built + 1 s, throw: {at: L4.1, from: {bearing: 0 deg, distance: 20 mm}, speed: 1 m/s, name: shot}}
    systems: [exact]
    expect: [{energy: {gain: <= 1 %}}]
"""


def keys(*tracks: list[tuple[float, float]]) -> np.ndarray:
    """Rows of a recording of bricks that go along x: times [s] and places [m]."""
    rows = np.zeros((sum(map(len, tracks)), COLUMNS))
    rows[:, NUMBER] = [number for number, track in enumerate(tracks) for _ in track]
    rows[:, TIME] = [time for track in tracks for time, _ in track]
    rows[:, POSITION.start] = [x for track in tracks for _, x in track]
    return rows


def test_between_two_pictures_bricks_go_as_far_as_between_any_others() -> None:
    # One falls from 1 s to 2 s at a steady speed, and lies still up to 10 s.
    falling = keys([(0.0, 0.0), *((1.0 + 0.1 * k, 0.1 * k) for k in range(11)), (10.0, 1.0)])
    assert times_of_motion(falling, 1.0, 10.0, 5) == pytest.approx([1.0, 1.25, 1.5, 1.75, 10.0])


def test_pictures_of_a_strip_without_motion_are_evenly_spaced() -> None:
    assert times_of_motion(keys([(0.0, 0.0)], [(1.0, 5.0)]), 0.0, 4.0, 3) == [0.0, 2.0, 4.0]


def test_no_two_pictures_of_a_fall_are_the_same() -> None:
    (run,) = views_of(SLANT_TOWER)
    panels = strip(run, VIEWS["front"], 6)
    drawn = re.findall(r"<svg x=.*?</svg>", picture(run, "", panels), re.DOTALL)
    assert len({re.sub(r"<text.*|[xy]=\S+", "", one) for one in drawn}) == 6


def test_a_strip_shows_the_thrown_brick() -> None:
    (run,) = views_of(THROWN)
    drawn = picture(run, "", strip(run, VIEWS["front"], 4))
    shown = 0
    for panel in re.findall(r"<svg x=.*?</svg>", drawn, re.DOTALL):
        wide, high = (float(re.search(rf'{side}="(\d+)"', panel)[1]) for side in ("width", "height"))  # type: ignore[index]
        for group in re.findall(r"<title>shot</title>(.*?)</g>", panel):
            places = [tuple(map(float, point)) for point in re.findall(r"[ML]([-\d.]+) ([-\d.]+)", group)]
            assert places
            assert all(0.0 <= x <= wide and 0.0 <= y <= high for x, y in places)
            shown += 1
    assert shown == 3  # all but the first, which it has not reached
