"""`stackdsl import`: what it prints is a scenario that says the same as the file, and plays."""

from pathlib import Path

import pytest

from stackdsl.exits import ExitCode
from tests.command_line import Stackdsl, stackdsl_in_folder, write
from tests.stackdsl.importing.loads import PALLET, PLAN, TABLE

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`


@pytest.mark.parametrize(
    ("text", "options", "bricks"),
    [(TABLE, ("--point", "corner"), 3), (PALLET, (), 3), (PLAN, ("--name", "My Plan"), 3)],
)
def test_what_is_printed_plays(
    stackdsl: Stackdsl, tmp_path: Path, text: str, options: tuple[str, ...], bricks: int
) -> None:
    write(tmp_path, text, "load.txt")
    printed = stackdsl("import", "load.txt", *options)
    assert printed.code == ExitCode.OK
    write(tmp_path, printed.out, "scene.yaml")
    done = stackdsl("run", "scene.yaml")
    assert (done.code, f"measured {bricks} bricks stand" in done.out) == (ExitCode.OK, True)


def test_what_was_moved_and_what_is_not_taken_is_told_and_stands_at_the_head(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    write(tmp_path, '"z": 144.0'.join(PALLET.rsplit('"z": 140.0', 1)), "order.json")
    printed = stackdsl("import", "order.json", "--settle", "within 5 mm")
    told = [
        "3 boxes in order.json, written to 1 mm",
        "1 of 3 boxes was lowered, box-3 most: by 4 mm",
        "not taken: orderID, description, shippingGroup, palletType, palletDimension, approach",
    ]
    assert printed.err.splitlines() == told
    assert printed.out.splitlines()[:3] == [f"# {line}" for line in told]


def test_a_file_that_is_wrong_is_told_in_its_place(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, TABLE.replace("5200", "5,200"), "load.csv")
    printed = stackdsl("import", "load.csv", "--point", "corner")
    assert (printed.code, printed.out) == (ExitCode.INVALID, "")
    assert printed.err.startswith("load.csv:2:1: SD114 the row has 9 cells, and the header 8\n")


@pytest.mark.parametrize(
    "options", [("--settle", "sideways"), ("--format", "lorry"), ("--format", "bed-bpp", "--point", "corner")]
)
def test_a_wrong_option_is_a_wrong_usage(stackdsl: Stackdsl, tmp_path: Path, options: tuple[str, ...]) -> None:
    write(tmp_path, TABLE, "load.csv")
    assert stackdsl("import", "load.csv", *options).code == ExitCode.USAGE
    assert stackdsl("import", "nowhere.csv").code == ExitCode.USAGE


def test_what_is_a_load_of_nothing_known_is_asked_for(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, "<lorry/>", "load.xml")
    printed = stackdsl("import", "load.xml")
    assert printed.code == ExitCode.INVALID
    assert "SD115 what this is cannot be told" in printed.err
