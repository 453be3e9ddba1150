"""Reading of anchors, times tied to events."""

import pytest

from stackdsl.language.model_base import Anchor, parse_anchor
from stackdsl.language.quantities import InputError


@pytest.mark.parametrize(
    ("written", "anchor"),
    [
        ("start", Anchor("start")),
        ("built", Anchor("built")),
        ("built + 2 s", Anchor("built", offset=2.0)),
        ("level 9 + 500 ms", Anchor("level", "9", 0.5)),
        ("level 9", Anchor("level", "9")),
        ("brick L3.2+1 s", Anchor("brick", "L3.2", 1.0)),
        (" brick  roof ", Anchor("brick", "roof")),
    ],
)
def test_an_anchor_names_an_event_and_a_time_after_it(written: str, anchor: Anchor) -> None:
    assert parse_anchor(written) == anchor


@pytest.mark.parametrize(
    ("written", "code"),
    [
        ("", "SD110"),
        ("build", "SD110"),
        ("2 s", "SD110"),
        (2, "SD110"),
        ("built 2 s", "SD110"),
        ("built - 2 s", "SD110"),
        ("level", "SD110"),
        ("level 0", "SD110"),
        ("level nine", "SD110"),
        ("brick", "SD110"),
        ("brick 3", "SD110"),
        ("built + 2", "SD105"),
        ("built + 2 mm", "SD106"),
        ("built + -2 s", "SD104"),
    ],
)
def test_a_malformed_anchor_is_refused(written: object, code: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_anchor(written)
    assert caught.value.code == code
