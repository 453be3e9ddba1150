"""Every Python block of the pages runs, and prints what the page says."""

import subprocess
import sys

import pytest

from tests.docs.pages import HAS_PYBULLET, NO_PYBULLET, Block, all_blocks
from tests.docs.shown_output import differences
from tests.paths import ROOT


@pytest.mark.parametrize("block", all_blocks("python"), ids=lambda block: block.name)
def test_python_blocks_run_and_print_what_the_page_says(block: Block) -> None:
    if block.marked("sketch") is not None:
        compile(block.text, block.name, "exec")
        return
    if "pybullet" in block.text and not HAS_PYBULLET:
        pytest.skip(NO_PYBULLET)
    done = subprocess.run([sys.executable, "-c", block.text], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    printed = "\n".join(line for line in done.stdout.splitlines() if "build time" not in line)  # PyBullet's own
    assert differences(block.marked("prints") or "...", printed) == []
