"""Golden files are named after scenario and variant, no two alike on any disk, as shells, git and Windows take it."""

import re
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from stackdsl.goldens.file_format import golden_name
from stackdsl.goldens.golden import is_there
from stackdsl.goldens.snapshot import Identity

NAMES = {
    ("tower", "thesis", "thesis"): "tower/thesis.json",
    ("tower", "step=10mm,thesis", "thesis"): "tower/step-10mm.thesis.json",
    ("tower", "step=1.5mm,count=3,stock", "stock"): "tower/step-1.5mm_count-3.stock.json",
    ("tower", "tilt=-5deg,exact", "exact"): "tower/tilt--5deg.exact.json",
    ("hit", "speed=2.5m/s,exact", "exact"): "hit/speed-2.5m-per-s.exact.json",
    ("full", "share=25%,exact", "exact"): "full/share-25pct.exact.json",
}
WITH_DIGEST = {
    ("con", "exact", "exact"): r"con-[0-9a-f]{10}/exact\.json",
    ("a", "N=4,exact", "exact"): r"a/n-4-[0-9a-f]{10}\.exact\.json",
    ("a", "x=(1+2)mm,exact", "exact"): r"a/x-1-2-mm-[0-9a-f]{10}\.exact\.json",
    ("..", "..", ""): r"x-[0-9a-f]{10}/x-[0-9a-f]{10}\.json",
    ("tårn", "", ""): r"t-rn-[0-9a-f]{10}/x-[0-9a-f]{10}\.json",
}
TAKEN_AS_IT_IS = re.compile(r"[a-z0-9][a-z0-9._-]*/[a-z0-9][a-z0-9._-]*\.json")


@pytest.mark.parametrize(("names", "file"), NAMES.items(), ids=NAMES.values())
def test_a_golden_file_is_named_after_its_scenario_and_variant(names: tuple[str, str, str], file: str) -> None:
    assert golden_name(Identity(*names)) == file


@pytest.mark.parametrize(("names", "pattern"), WITH_DIGEST.items(), ids=range(len(WITH_DIGEST)))
def test_a_golden_name_has_a_digest_if_characters_are_lost(names: tuple[str, str, str], pattern: str) -> None:
    assert re.fullmatch(pattern, golden_name(Identity(*names)))


PAIRS = st.tuples(st.text(max_size=80), st.text(max_size=80))
ALIKE = st.text(st.sampled_from("ab=-_,./%1"), max_size=8)


@settings(max_examples=60)
@given(PAIRS | st.tuples(ALIKE, ALIKE), PAIRS | st.tuples(ALIKE, ALIKE))
@example(("a", "b=1,c=2"), ("a", "b=1_c-2"))
@example(("a", "b=1,c_d=2"), ("a", "b=1_c,d=2"))
@example(("a", "b=1/2"), ("a", "b=1-per-2"))
@example(("a", "b"), ("A", "b"))
@example(("a", "b=1"), ("a", "B=1"))
@example(("x" * 80, ""), ("x" * 79 + "y", ""))
@example(("x" * 80, ""), (golden_name(Identity("x" * 80, "", "")).split("/")[0], ""))
@example(
    ("a", "b=C"), ("a", golden_name(Identity("a", "b=C", "")).split("/")[1].removesuffix(".json").replace("-", "=", 1))
)
def test_no_two_variants_share_a_file_on_any_disk(one: tuple[str, str], other: tuple[str, str]) -> None:
    names = [golden_name(Identity(*names, system="")) for names in (one, other)]
    assert (names[0].casefold() == names[1].casefold()) is (one == other)
    assert all(TAKEN_AS_IT_IS.fullmatch(name) for name in names)
    assert all(len(part) <= 143 for name in names for part in name.split("/"))


@pytest.mark.parametrize("keeper", ["a" * 5000, "nobody.py", "\0"], ids=["too long", "gone", "no name"])
def test_an_impossible_keeper_keeps_no_golden_file(tmp_path: Path, keeper: str) -> None:
    assert not is_there(keeper, tmp_path / "golden")
