"""Every Python block of the pages runs, and prints what the page says."""

import pytest

from tests.command_line import StackdslIn
from tests.docs.pages import HAS_PYBULLET, NO_PYBULLET, Block, all_blocks
from tests.docs.shown_output import differences
from tests.paths import ROOT


@pytest.mark.parametrize("block", all_blocks("python"), ids=lambda block: block.name)
def test_python_blocks_run_and_print_what_the_page_says(block: Block, stackdsl_in: StackdslIn) -> None:
    if block.marked("sketch") is not None:
        compile(block.text, block.name, "exec")
        return
    if "pybullet" in block.text and not HAS_PYBULLET:
        pytest.skip(NO_PYBULLET)
    done = stackdsl_in(ROOT, program=block.text)
    assert done.code == 0, done.err
    assert differences(block.marked("prints") or "...", done.out) == []
