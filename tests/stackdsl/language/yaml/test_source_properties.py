"""Whatever is dumped is read back, any text is read or refused, alike each time."""

from typing import Any

import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from stackdsl.language.yaml.parsing import commanding_character
from stackdsl.language.yaml.source import parse
from tests.stackdsl.language.yaml.sources import REMEDIES, each_parser, values

__all__ = ["each_parser"]  # used by every test here


def texts(most: int) -> st.SearchStrategy[str]:
    """Generate texts of printable characters; control characters are rejected (test_commanding_characters.py)."""
    return st.text(max_size=most).filter(lambda text: not commanding_character(text))


SCALARS = st.one_of(
    texts(30),
    st.sampled_from([text for text, _ in REMEDIES]),
    st.integers(-(2**53), 2**53),
    st.floats(allow_nan=False, allow_infinity=False),
    st.booleans(),
)
KEYS = texts(20) | st.sampled_from(["no", "1", "<<", "1:30", "null"])
NESTED = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=4), max_leaves=20
)
SCENARIOS = st.dictionaries(KEYS, NESTED, max_size=5)
YAML_TEXTS = st.lists(
    st.sampled_from(["a", "1", " ", "  ", "\n", ": ", "- ", "[", "]", "{", "}", ", ", '"', "'", "|", ">", "&x ", "*x"])
    | st.sampled_from(
        ["!t ", "? ", " #", "\\", "%", "\t", "---\n", "...\n", "±", "\r\n", "~", "@", "<<: ", "\0", "no"]
    ),
    max_size=20,
).map("".join)


class QuotingDumper(yaml.SafeDumper):
    """Quotes all text, for PyYAML would leave some traps plain, such as `1e3` or `y`."""


QuotingDumper.add_representer(
    str, lambda dumper, text: dumper.represent_scalar("tag:yaml.org,2002:str", text, style='"')
)


@settings(max_examples=40)  # each of many values
@given(scenario=SCENARIOS, flow=st.booleans())
@example(scenario={"a": "1e3", "y": "y", "b": ["", {}, []]}, flow=False)
@example(scenario={"a": "\ufeff\t\n\xa0\u3000"}, flow=True)
def test_what_is_dumped_is_read_back(scenario: dict[str, Any], flow: bool) -> None:
    text = yaml.dump(
        scenario, Dumper=QuotingDumper, default_flow_style=flow, sort_keys=False, width=10**6
    )  # a key is one line
    assert repr(values(text)) == repr(scenario)  # by text, for True == 1 == 1.0


@given(YAML_TEXTS)
def test_any_text_is_either_read_or_refused_and_twice_the_same(text: str) -> None:
    loaded = parse(text, "a.yaml")
    assert loaded.sources or loaded.diagnostics
    assert parse(text, "a.yaml") == loaded
    assert all(diagnostic.hint and diagnostic.span.column >= 1 for diagnostic in loaded.diagnostics)


@given(YAML_TEXTS)
def test_mistakes_come_in_the_order_of_the_text(text: str) -> None:
    places = [(each.span.line, each.span.column) for each in parse(text, "a.yaml").diagnostics]
    assert places == sorted(places)
