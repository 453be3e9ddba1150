"""Which cases are selected; and where there are none, why, and what to do about it."""

from pathlib import Path

import pytest

from stackdsl.checking.cases import gather
from stackdsl.checking.selection import Selection, nothing_selected_text
from tests.command_line import GOOD, Stackdsl, stackdsl_in_folder, write
from tests.scenes import compiled

__all__ = ["stackdsl_in_folder"]  # the fixture `stackdsl`

CASES = compiled(f"{GOOD}tags: [small]\n---\n{GOOD.replace('good', 'better')}")[0]


@pytest.mark.parametrize(
    ("selection", "told"),
    [
        (Selection(keyword="goood"), "no case has 'goood' in its name (did you mean 'good'?)"),
        (Selection(tags=("smal",)), "no scenario has the tag 'smal' (did you mean 'small'?)"),
        (Selection(("tuned",)), "no scenario has tuned among its `systems`"),
        (Selection(keyword="better", tags=("small",)), "no case meets all criteria together"),
        (Selection(tags=("!small",), keyword="[tuned]"), "no case has '[tuned]' in its name"),
    ],
)
def test_what_no_case_has_is_named(selection: Selection, told: str) -> None:
    assert selection.of(CASES) == []
    text = nothing_selected_text(selection, CASES, [])
    assert told in text
    assert "--list" in text


def test_a_peer_is_played_wherever_it_is_asked_for_so_it_is_no_reason() -> None:
    asked = Selection(("mujoco",), keyword="goood")
    assert asked.of(CASES) == []
    assert "played on" not in nothing_selected_text(asked, CASES, [])


@pytest.mark.parametrize("form", ["text", "json"])
def test_a_directory_without_scenarios_is_told_and_is_wrong_usage(
    stackdsl: Stackdsl, tmp_path: Path, form: str
) -> None:
    (tmp_path / "empty").mkdir()
    result = stackdsl("check", "empty", "--format", form)
    assert result.code == 4
    assert "no scenario in empty" in result.err
    assert "stackdsl new" in result.err
    assert form == "text" or '"exit_code": 4' in result.out


@pytest.mark.parametrize("command", ["check", "run", "explain"])
def test_every_command_says_why_it_selects_nothing(stackdsl: Stackdsl, tmp_path: Path, command: str) -> None:
    write(tmp_path, GOOD)
    result = stackdsl(command, "scene.yaml", "-k", "goood")
    assert result.code == 4
    assert "did you mean 'good'?" in result.err


def test_a_name_that_two_files_use_is_told_with_both_places(tmp_path: Path) -> None:
    for name in ("a.yaml", "b.yaml"):
        write(tmp_path, GOOD, name)
    gathered = gather([tmp_path])
    assert gathered.cases == ()
    (only,) = gathered.diagnostics
    assert (only.code, only.span.file) == ("SD203", (tmp_path / "b.yaml").as_posix())
    other = f"{(tmp_path / 'a.yaml').as_posix()}:1:11"
    assert f"two scenarios are called 'good'; the other one is at {other}" in only.message
    assert "-k" in only.hint
