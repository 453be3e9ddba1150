"""The leaning structure of the publication: a four-stack that falls at the level that moments give."""

import pytest

from stability.problem import Stability
from stackdsl.language.layouts.four_stack import FourStackParams, four_stack
from stackdsl.language.layouts.leaning_structure import LeaningStructureParams, leaning_structure
from stackdsl.language.layouts.registry import BrickSpec
from tests.stackdsl.language.layouts.layout_shapes import KAPLA, LENGTH, standing


def leaning(**written: object) -> tuple[BrickSpec, ...]:
    return leaning_structure(LeaningStructureParams.model_validate({"levels": 14, **written}), KAPLA)


def test_the_leaning_structure_is_a_four_stack_that_steps_by_11_per_cent_of_its_length() -> None:
    stack = FourStackParams.model_validate({"levels": 14, "step": f"{110 * LENGTH} mm", "spacing": "78.4 mm"})
    for one, other in zip(leaning(), four_stack(stack, KAPLA), strict=True):
        assert one.position == pytest.approx(other.position, abs=1e-12)
        assert (one.level, one.yaw) == (other.level, other.yaw)


@pytest.mark.parametrize(("step", "spacing"), [(0.11 * LENGTH, LENGTH * 2 / 3), (0.0121, 0.0784), (0.0105, 0.080)])
def test_the_leaning_structure_falls_at_the_level_that_moments_give(step: float, spacing: float) -> None:
    #  The leading plank of level 2 and all above turn about the end of level 1, once their centre is beyond it.
    xs = [(level - 1) * step for level in range(3, 15) for _ in range(2)]  # plank by plank, from level 3
    beyond = [(step + spacing / 2 + sum(xs[:count])) / (count + 1) > LENGTH / 2 for count in range(1, len(xs) + 1)]
    falls_with = 4 + beyond.index(True) + 1  # so many planks
    assembly = standing(0.5, leaning(step=f"{step} m", spacing=f"{spacing} m"))
    assert assembly.verdict().stability is Stability.UNSTABLE
    assert len(assembly.bricks) == falls_with


def test_by_default_the_leaning_structure_falls_with_the_first_plank_of_level_9() -> None:
    assert len(standing(0.5, leaning()).bricks) == 2 * 8 + 1
