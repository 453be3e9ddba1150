"""What shell blocks ask for exists: targets of make, extras of the package, subcommands."""

import re
import tomllib

import pytest

from stackdsl.cli.main import COMMANDS
from tests.docs.pages import Block, all_blocks
from tests.paths import ROOT

TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]


@pytest.mark.parametrize("block", all_blocks("sh"), ids=lambda block: block.name)
def test_shell_blocks_ask_for_what_there_is(block: Block) -> None:
    assert set(re.findall(r"^make ([a-z-]+)", block.text, re.MULTILINE)) <= TARGETS
    assert set(re.findall(r"stackdsl\[([a-z]+)\]", block.text)) <= set(EXTRAS)
    assert set(re.findall(r"^stackdsl ([a-z]+)", block.text, re.MULTILINE)) <= set(COMMANDS)


def test_readme_gives_the_two_commands_first() -> None:
    first = next(block for block in all_blocks("sh") if block.page.name == "README.md")
    assert [line.split("#")[0].strip() for line in first.text.splitlines()] == ["make check", "make test"]
