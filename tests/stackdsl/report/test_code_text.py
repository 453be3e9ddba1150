"""What `explain` says of each code: an entry for every one, and examples that give it."""

from pathlib import Path

import pytest

from stackdsl.checking.cases import cases_of, gather
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import blocked_result
from stackdsl.diagnostics import CODES
from stackdsl.importers.expansion import expand_file
from stackdsl.language.yaml.includes import Library
from stackdsl.language.yaml.parsing import MAX_DEPTH
from stackdsl.language.yaml.source import MAX_BYTES, Loaded, load, parse
from stackdsl.report.diagnostics import code_text, entries
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from tests.paths import ROOT

ENTRIES = entries()
PAGE = (ROOT / "stackdsl" / "diagnostics.md").read_text(encoding="utf-8")
OF_A_RUN = ("SD208", "SD210")
EXAMPLES = {code: entry.example for code, entry in ENTRIES.items() if entry.example and code not in OF_A_RUN}


def test_every_code_has_an_entry_and_every_entry_a_code() -> None:
    assert sorted(ENTRIES) == sorted(CODES)


@pytest.mark.parametrize("code", ENTRIES)
def test_an_entry_says_what_it_means_and_what_to_do(code: str) -> None:
    entry = ENTRIES[code]
    meaning, remedy = entry.body.split("**Remedy.** ")
    assert meaning.strip()
    assert remedy.strip()


@pytest.mark.parametrize("code", EXAMPLES)
def test_an_example_gives_its_code_alone(code: str, tmp_path: Path) -> None:
    file = tmp_path / "example.yaml"
    file.write_text(EXAMPLES[code], encoding="utf-8")
    assert {mistake.code for mistake in gather([file]).diagnostics} == {code}


@pytest.mark.parametrize("code", OF_A_RUN)
def test_the_example_of_a_run_is_held_up_by_what_is_in_the_way(code: str) -> None:
    (case,), mistakes = cases_of(parse(ENTRIES[code].example or "", "example.yaml"))
    assert mistakes == []
    with pytest.raises(BlockedPlacementError) as held_up_by:
        play_case(case.timeline, case.system)
    told = blocked_result(case, held_up_by.value.blocked).mistake
    assert told is not None
    assert told.code == code
    assert told.hint


def imported(file: str, folder: Path) -> Loaded:
    """A scenario that imports a file of a folder."""
    text = f"scenario: load\nbuild:\n  - import: {{file: {file}}}\n"
    return expand_file(parse(text, str(folder / "load.yaml")), Library())


def test_what_has_no_short_example_is_given_by_what_its_entry_describes(tmp_path: Path) -> None:
    latin, large = tmp_path / "latin.yaml", tmp_path / "large.yaml"
    latin.write_bytes("scenario: t\u00fcrme".encode("latin-1"))
    large.write_text("#" * (MAX_BYTES + 1))
    deep = "[" * (MAX_DEPTH + 1) + "]" * (MAX_DEPTH + 1)
    in_the_air = "".join(f"      - {{at: [0 mm, 0 mm, {n} m]}}\n" for n in range(1, 102))
    (tmp_path / "load.csv").write_text("length [mm]\n1\n")
    (tmp_path / "load.json").write_text("[{}")
    given = {
        "SD001": load(tmp_path / "nothing.yaml"),
        "SD002": load(latin),
        "SD006": load(large),
        "SD007": parse(f"scenario: tower\nbuild: {deep}\n", "deep.yaml"),
        "SD114": imported("load.json", tmp_path),
        "SD115": imported("load.csv", tmp_path),
        "SD111": parse(f"scenario: many\nbuild:\n  - bricks:\n{in_the_air}", "many.yaml"),
    }
    assert set(given) == ENTRIES.keys() - EXAMPLES.keys() - {*OF_A_RUN}
    for code, loaded in given.items():
        assert code in [mistake.code for mistake in cases_of(loaded)[1]]


def test_the_text_of_a_code_has_no_markdown() -> None:
    told = code_text(ENTRIES["SD101"])
    assert told.startswith("SD101: unknown key\n\nThere is no key of this name here.")
    assert "\n    scenario: tower\n    gravity: 1.62 m/s2\n" in told
    assert "look up its place in the language" in told
    assert not any(mark in told for mark in ("**", "```", "](", "<!--"))


def test_the_page_is_read_whole() -> None:
    assert PAGE.count("\n## ") == len(ENTRIES)
