"""Every command that a page shows is run, in order, on the files that the page says to write."""

import shlex
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from tests.command_line import Stackdsl, write
from tests.docs.pages import HAS_PYBULLET, NO_PYBULLET, PAGES, Block, blocks
from tests.docs.shown_output import differences
from tests.paths import ROOT

WITH_OUTPUT = [page for page in PAGES if any(block.marked("output of") for block in blocks(page))]


@pytest.mark.skipif(not HAS_PYBULLET, reason=NO_PYBULLET)
@pytest.mark.parametrize("page", WITH_OUTPUT, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_shows_what_its_commands_print(page: Path, stackdsl: Stackdsl, tmp_path: Path) -> None:
    for block in blocks(page):
        if (name := block.marked("file")) is not None:
            write(tmp_path, block.text, name)
        elif (command := block.marked("output of")) is not None:
            _hold(block, command, _with_package_of(tmp_path, stackdsl))


def _with_package_of(folder: Path, stackdsl: Stackdsl) -> Stackdsl:
    """Return the command, with the package installed that the page says to write, if there is one."""
    if not (folder / "pyproject.toml").exists():
        return stackdsl
    site = folder / "site"
    if not site.exists():
        pip = (sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--quiet", "--no-index")
        subprocess.run([*pip, "--no-deps", "--no-build-isolation", "--target", str(site), "."], cwd=folder, check=True)
    main = "from stackdsl.__main__ import main; main()"
    return partial(stackdsl, program=f"import sys; sys.path.insert(0, {str(site)!r}); {main}")


def _hold(block: Block, command: str, stackdsl: Stackdsl) -> None:
    called, _, code = command.partition("; exit ")
    program, *arguments = shlex.split(called)
    assert program == "stackdsl"
    result = stackdsl(*arguments)
    assert result.code == int(code or 0), result.text
    assert differences(block.text, result.out) == [], result.out


def test_readme_and_the_tutorial_show_output() -> None:
    assert {page.name for page in WITH_OUTPUT} >= {"README.md", "tutorial.md"}
