"""Ties in pictures and replays: drawn as soon as all their bricks are placed."""

import pytest

from stackdsl.viewing.drawing import VIEWS
from stackdsl.viewing.pictures import heading_at, panels_at, picture
from stackdsl.viewing.replay.page import payload_of
from tests.stackdsl.viewing.views import views_of

STRAPPED = """
    scenario: strapped
    brick: {size: [400 mm, 300 mm, 200 mm], mass: 9 kg}
    build: [{column: {levels: 2}, every: 1 s}]
    ties: [{around: all, along: 0 deg, tension: 50 N}]
    expect: [{stands: all}]
"""


@pytest.mark.parametrize(("time", "drawn"), [(0.5, 0), (1.5, 2)])
def test_a_strap_is_drawn_from_the_placement_of_its_last_brick_on(time: float, drawn: int) -> None:
    (run,) = views_of(STRAPPED)
    svg = picture(run, heading_at(run, time), panels_at([VIEWS["front"]], time))
    assert svg.count('class="tie"') == drawn  # with its halo


def test_a_replay_tells_the_course_and_the_bricks_of_a_tie() -> None:
    (tie,) = payload_of(views_of(STRAPPED)[0])["ties"]
    assert tie["bricks"] == [0, 1]
    assert tie["points"][0] == tie["points"][-1]
    assert {(abs(x), y, z) for x, y, z in tie["points"]} == {(0.2, 0.0, 0.0), (0.2, 0.0, 0.4)}
