"""The pages of units, columns, installation and citation name what the program has."""

import re
import tomllib

import pytest
import yaml

from stackdsl.language import quantities
from stackdsl.language.quantities import Dimension, in_si
from stackdsl.report.formats import COSTS, FIXED
from tests.paths import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
KINDS = {
    kind.noun: kind
    for name, kind in reversed(vars(quantities).items())  # of kinds with one noun, the first is the widest
    if isinstance(kind, Dimension) and kind.needs_unit
}


def page(name: str) -> str:
    return (ROOT / "docs" / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_a_reader_finds_the_units_and_the_limits_of_each_quantity(kind: Dimension) -> None:
    row = next(line for line in page("units.md").splitlines() if line.startswith(f"| {kind.noun} |"))
    _, units, example, limits = (cell.strip() for cell in row.strip("|").split("|"))
    least, most = limits.replace("`", "").split(" .. ")
    assert re.findall(r"`(.*?)`", units) == [*kind.units[:-1], *(["g"] if kind.gravities else []), kind.units[-1]]
    assert example == f"`{kind.example}`"
    assert least == "above 0" if kind.positive else _si(least) == pytest.approx(kind.least)
    assert _si(most) == pytest.approx(kind.most)


def _si(written: str) -> float:
    number, _, unit = written.partition(" ")
    return float(number) * float(in_si(unit))


def test_a_reader_finds_each_column_of_csv() -> None:
    named = re.findall(r"`(\w+)`", page("columns.md").split("## CSV")[1].split("## Terms")[0])
    assert set(named) >= {*FIXED, *COSTS}


def test_a_reader_finds_each_optional_part() -> None:
    named = re.findall(r"`(\w+)`", page("install.md").split("## Optional parts")[1].split("SAPIEN")[0])
    assert set(named) >= set(PROJECT["optional-dependencies"])


def test_the_citations_are_those_of_this_version() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == PROJECT["version"]
    assert f"version = {{{PROJECT['version']}}}" in page("cite.md")
    assert [work["title"] for work in citation["references"] if work["title"] not in page("cite.md")] == []
