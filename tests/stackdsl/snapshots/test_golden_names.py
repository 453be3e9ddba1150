"""Golden files are named after scenario and variant, no two alike on any disk."""

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from stackdsl.snapshots.golden import (
    golden_name,
)
from stackdsl.snapshots.record import Identity

NAMES = {
    ("tower", "thesis"): "tower[thesis].json",
    ("tower", "step=10mm,thesis"): "tower[step=10mm,thesis].json",
    ("tower", "step=1.5mm,stock"): "tower[step=1.5mm,stock].json",
    ("Tower", "N=4"): "%54ower[%4e=4].json",
    ("tower", ""): "tower[].json",
    ("a/b\\c", "x:y*?"): "a%2fb%5cc[x%3ay%2a%3f].json",
    ("..", "100%"): "%2e%2e[100%25].json",
    ("con.txt", "a b"): "con%2etxt[a%20b].json",
    ("a[b]", "c"): "a%5bb%5d[c].json",
    ("tårn", "c"): "t%c3%a5rn[c].json",
}


@pytest.mark.parametrize(("names", "file"), NAMES.items(), ids=NAMES.values())
def test_a_golden_file_is_named_after_its_scenario_and_variant(names: tuple[str, str], file: str) -> None:
    assert golden_name(Identity(*names, system="")) == file


PAIRS = st.tuples(st.text(max_size=80), st.text(max_size=80))


@given(PAIRS, PAIRS)
@example(("a[b", "c"), ("a", "b[c"))
@example(("a", "b"), ("A", "b"))
@example(("a", "b"), ("a", "B"))
@example(("x" * 80, ""), ("x" * 79 + "y", ""))
@example(("%41", ""), ("A", ""))
def test_no_two_variants_share_a_file_on_any_disk(one: tuple[str, str], other: tuple[str, str]) -> None:
    names = [golden_name(Identity(*names, system="")) for names in (one, other)]
    assert (names[0].casefold() == names[1].casefold()) is (one == other)
    assert all(len(name) <= 143 and name.isascii() and "/" not in name for name in names)
