"""What is far away and touches nothing changes no digit of what moves."""

import pytest

from stackdsl.playing.runner import play
from stackdsl.systems.systems import SYSTEMS
from tests.scenes import timeline_of

FIN_AND_PLANK = """
- bricks:
    - {name: fin, brick: {size: [60 mm, 3.43 mm, 40 mm], density: 700 kg/m3}, at: [0 mm, 0 mm, 20 mm]}
    - {name: plank, at: [0 mm, 4 mm, 43.9 mm]}
"""
# A sheet by far thinner than all else, a plank like the one that falls, a tower of a hundred of them.
FAR_AWAY = {
    "sheet": """
- bricks:
    - {name: sheet, brick: {size: [50 mm, 50 mm, 0.0128 mm], density: 700 kg/m3}, at: [0 mm, -150 mm, 0.0064 mm]}
""",
    "plank": "- bricks: [{name: other, at: [0 mm, 500 mm, 3.9 mm]}]",
    "tower": "- four_stack: {levels: 50, origin: [1 m, 0 mm, 0 mm]}",
}


@pytest.mark.parametrize("far", FAR_AWAY)
@pytest.mark.parametrize("before", [True, False], ids=["before", "after"])
def test_a_plank_that_tips_over_a_fin_falls_alike_whatever_stands_elsewhere(far: str, before: bool) -> None:
    steps = [FAR_AWAY[far], FIN_AND_PLANK] if before else [FIN_AND_PLANK, FAR_AWAY[far]]
    alone = play(timeline_of(FIN_AND_PLANK), SYSTEMS["exact"])
    beside = play(timeline_of("\n".join(steps)), SYSTEMS["exact"])
    for name in ("fin", "plank"):
        assert repr(beside.tracks[name].final) == repr(alone.tracks[name].final)
    assert beside.cost.steps == alone.cost.steps > 0
    assert alone.collapse is not None
    assert beside.collapse is not None
    assert beside.collapse.time == alone.collapse.time
