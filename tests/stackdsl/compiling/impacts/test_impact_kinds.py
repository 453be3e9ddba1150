"""Every kind of impact comes to something in the scene."""

import pytest

from stability.model import IDENTITY
from stackdsl.compiling.impacts.actions import actions_of
from stackdsl.compiling.impacts.scene import Scene
from stackdsl.compiling.moment import START
from stackdsl.language.impacts.impact_kind import IMPACTS, ImpactKind
from stackdsl.language.impacts.insert import Insert


@pytest.mark.parametrize("key", IMPACTS)
def test_a_kind_says_what_it_comes_to_or_slides_a_brick_in(key: str) -> None:
    kind = IMPACTS[key].model
    assert actions_of.dispatch(kind) is not actions_of.dispatch(object) or kind is Insert


def test_a_kind_that_says_nothing_is_named() -> None:
    scene = Scene(START, (), {}, (), 9.81, IDENTITY)
    with pytest.raises(NotImplementedError, match="nothing says what Nothing comes to"):
        actions_of(type("Nothing", (ImpactKind,), {})(), scene)
