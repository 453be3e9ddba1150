"""`explain` of a code rather than of a file."""

from pathlib import Path

from stackdsl.exits import ExitCode
from tests.command_line import GOOD, Stackdsl, stackdsl_in_folder, write

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`


def test_a_code_is_told_with_its_example_and_remedy(stackdsl: Stackdsl) -> None:
    done = stackdsl("explain", "SD105")
    assert done.code == ExitCode.OK
    assert done.out.startswith("SD105: a number without its unit\n")
    assert "\n      - column: {levels: 3, step: 12}\n" in done.out
    assert "Remedy. Write the unit after the number: `12 mm`." in done.out


def test_a_code_that_there_is_not_is_refused_with_the_codes(stackdsl: Stackdsl) -> None:
    done = stackdsl("explain", "SD199")
    assert done.code == ExitCode.USAGE
    assert "unknown diagnostic code SD199; the codes are SD001 to SD010, SD101 to " in done.err


def test_a_file_that_is_called_like_a_code_is_a_file(stackdsl: Stackdsl, tmp_path: Path) -> None:
    write(tmp_path, GOOD, "SD105")
    done = stackdsl("explain", "SD105")
    assert (done.code, "statics: " in done.out) == (ExitCode.OK, True)
