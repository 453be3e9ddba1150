"""Every kind of impact comes to something in the scene."""

import pytest

from stability.model import IDENTITY
from stackdsl.compiler.bricks import START
from stackdsl.compiler.impact_scene import ImpactScene
from stackdsl.compiler.impacts import actions_of
from stackdsl.language.impacts import IMPACTS, ImpactKind, Insert


@pytest.mark.parametrize("key", IMPACTS)
def test_a_kind_says_what_it_comes_to_or_slides_a_brick_in(key: str) -> None:
    kind = IMPACTS[key].model
    assert actions_of.dispatch(kind) is not actions_of.dispatch(object) or kind is Insert


def test_a_kind_that_says_nothing_is_named() -> None:
    scene = ImpactScene(START, (), {}, (), 9.81, IDENTITY)
    with pytest.raises(NotImplementedError, match="no function is registered for Nothing"):
        actions_of(type("Nothing", (ImpactKind,), {})(), scene)
