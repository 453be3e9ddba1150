"""Replays draw round bricks with the rims of their flat ends alone."""

import pytest

from stackdsl.viewing.replay.page import payload_of
from tests.stackdsl.viewing.views import views_of


@pytest.mark.parametrize(
    ("brick", "flat"),
    [
        ("cylinder: {diameter: 60 mm, height: 100 mm}", 2),
        ("cone: {bottom: 60 mm, top: 0 mm, height: 100 mm}", 1),
        ("size: [60 mm, 60 mm, 100 mm]", 6),
    ],
)
def test_only_flat_ends_have_rims_in_a_replay(brick: str, flat: int) -> None:
    text = f"""
        scenario: one
        brick: {{{brick}, mass: 1 kg}}
        build: [bricks: [on: ground]]
        expect: [verdict: stable]
    """
    (shape,) = payload_of(views_of(text)[0])["shapes"]
    curved = set(shape.get("curved", ()))
    assert len(shape["faces"]) - len(curved) == flat
    for number, face in enumerate(shape["faces"]):
        heights = {shape["corners"][corner][2] for corner in face}
        assert (len(heights) > 1) is (number in curved) or "size" in brick
