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
    woken = next(line for line in lines if "  moves " in line)
    assert (f"  {FALLING}: L2.1 to L10.1" in woken) == whole
    assert woken.endswith("  L2.1 to L10.1 (9 bricks) tip over L1.1") != whole
    assert any(line.startswith("fallen: ") for line in lines) == whole
