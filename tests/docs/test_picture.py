"""The picture of README is that of its scenario."""

from benchmarks.figures.picture import PATH, drawn, played
from tests.engines_at_hand import needs_pybullet


@needs_pybullet
def test_the_picture_is_that_of_the_scenario() -> None:
    assert drawn(played()) == PATH.read_text(encoding="utf-8")
