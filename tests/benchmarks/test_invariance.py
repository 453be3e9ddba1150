"""A hit does the same whatever the place and the names of a scene, and what stands apart from it."""

from collections.abc import Callable

import pytest

from benchmarks.invariance import CHANGES, COMPARED, OTHER, PUSHED, SCENES, Change, Scene, differences, shifts

UNSYMMETRIC = "tower, plank thrown askew at an end"


def worst(scene: Scene, made: Callable[[Scene], Change], system: str) -> dict[str, float]:
    change = made(scene)
    return differences(shifts(scene, COMPARED[system]), change, shifts(change.scene, COMPARED[system]))


@pytest.mark.parametrize("kind", ["names", "place", "apart"])
def test_a_hit_does_the_same_in_a_scene_that_is_renamed_moved_or_beside_another(kind: str) -> None:
    changed = worst(SCENES[UNSYMMETRIC](), CHANGES[kind][0], "exact")
    assert changed["pushed"] <= PUSHED
    assert changed["other"] <= OTHER
