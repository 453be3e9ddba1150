"""`run --all-names` leaves no name out."""

from pathlib import Path

import pytest

from tests.command_line import Stackdsl, stackdsl_in_folder, write
from tests.engines_at_hand import needs_pybullet

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

LEANING = "scenario: leaning\nbuild:\n  - column: {levels: 12, step: 12 mm}\n    every: 1 s\n"
FALLING = ", ".join(f"L{level}.1" for level in range(2, 11))


@needs_pybullet
@pytest.mark.parametrize(("option", "whole"), [((), False), (("--all-names",), True)])
def test_every_brick_is_named_on_demand(
    stackdsl: Stackdsl, tmp_path: Path, option: tuple[str, ...], whole: bool
) -> None:
    write(tmp_path, LEANING, "leaning.yaml")
    lines = stackdsl("run", "leaning.yaml", *option).out.splitlines()
    woken = next(line for line in lines if "  woken " in line)
    assert (f"  {FALLING}: L2.1, " in woken) == whole
    assert ("  L2.1, L3.1, L4.1, L5.1, L6.1, L7.1 and 3 more: " in woken) != whole
    assert any(line.startswith("fallen: ") for line in lines) == whole
