"""Every YAML block of the pages: whole scenarios do what they say, fragments are valid in a scenario that has them."""

import re
from typing import Any

import pytest
import yaml

from stackdsl.checking.cases import cases_of
from stackdsl.checking.play_case import play_case
from stackdsl.judging.judge import judge
from stackdsl.language.yaml.source import parse
from tests.docs.pages import HAS_PYBULLET, Block, all_blocks

SCENARIO_BLOCKS = [block for block in all_blocks("yaml") if "github" not in block.mark]
WHOLE = [block for block in SCENARIO_BLOCKS if re.search(r"^scenario:", block.text, re.MULTILINE)]
FRAGMENTS = [block for block in SCENARIO_BLOCKS if block not in WHOLE]
PLAYED = [  # the commands of a page play its files, and `make check` the files of scenarios/
    block for block in WHOLE if block.marked("file") is None and block.marked("shown") is None
]


def tower() -> dict[str, Any]:
    """What fragments are put into: a tower of 13 levels."""
    return {
        "scenario": "fragment",
        "build": [{"four_stack": {"levels": 13}, "every": "1 s"}],
        "expect": [{"stands": "all"}],
    }


def completed(block: Block) -> str:
    """A fragment within a whole scenario; where it has a part of its own, that one counts."""
    part, whole = parse(block.text, block.name).sources[0].values, tower()
    if (key := block.marked("within")) is not None:
        whole[key] = [part]
    else:
        whole |= part
    return str(yaml.safe_dump(whole, allow_unicode=True, sort_keys=False))


def mistakes_of(text: str, block: Block) -> list[str]:
    return [mistake.code for mistake in cases_of(parse(text, block.name))[1]]


@pytest.mark.parametrize("block", PLAYED, ids=lambda block: block.name)
def test_whole_scenarios_do_what_they_say(block: Block) -> None:
    if (code := block.marked("mistake")) is not None:
        assert mistakes_of(block.text, block) == [code]
        return
    cases, mistakes = cases_of(parse(block.text, block.name))
    assert mistakes == []
    for case in (case for case in cases if HAS_PYBULLET or case.system == "exact"):
        trace = play_case(case.timeline, case.system)
        outcomes = judge(trace, case.scenario, case.variant, case.source, case.system)
        assert [outcome for outcome in outcomes if not outcome.passed] == []


@pytest.mark.parametrize("block", FRAGMENTS, ids=lambda block: block.name)
def test_fragments_are_valid_in_a_scenario_that_has_them(block: Block) -> None:
    assert mistakes_of(completed(block), block) == ([block.marked("mistake")] if block.marked("mistake") else [])


def test_the_language_page_shows_scenarios_and_fragments() -> None:
    assert any(block.page.name == "language.md" for block in PLAYED)
    assert len(FRAGMENTS) >= 5
