"""Remedies give what to write literally: followed to the letter, the scenario is valid."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from pydantic import ValidationError

from stackdsl.checking.cases import gather
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.json_schema import example_at, keys_at, nodes_at
from stackdsl.language.schema import models
from stackdsl.language.yaml.includes import INCLUDE
from stackdsl.language.yaml.parsing import TEXT_KEYS
from stackdsl.language.yaml.source import KeyPath
from tests.scenes import compiled

HEAD = "scenario: tower\nbrick: kapla\nfriction: 0.5\n"
BUILD = "build:\n  - column: {levels: 8}\n"
EXPECT = "expect:\n  - stands: all\n"
THROW = f"{HEAD}{BUILD}impacts: [{{throw: {{at: L3.1, from: {{bearing: 90 deg}}, speed: 2 m/s}}}}]\n"
TWO = """scenario: two
build:
  - bricks:
      - {name: base, at: [0 mm, 0 mm, 3.9 mm]}
      - {name: top, at: [0 mm, 0 mm, 7.8 mm]}
"""


def only(text: str) -> Diagnostic:
    (mistake,) = compiled(text)[1]
    return mistake


@pytest.mark.parametrize(
    ("text", "remedy", "wrong", "right"),
    [
        (HEAD + BUILD.replace("- column", "column"), "write `- column: {levels: 8}`", "  column", "  - column"),
        (
            HEAD + BUILD + "expect: {stands: all}\n",
            "write `expect: [{stands: all}]`",
            "{stands: all}",
            "[{stands: all}]",
        ),
        (HEAD.replace("brick:", "bricks:") + BUILD, "did you mean 'brick'?", "bricks:", "brick:"),
        (
            HEAD + BUILD + EXPECT.replace("stands: all", "stable: true"),
            "write `stands: all`",
            "stable: true",
            "stands: all",
        ),
        (
            HEAD + BUILD + "expect: [{rests_on: {brick: L2.1, on: L1.1}}]\n",
            "write `support` in place of `on`",
            "on: L1.1",
            "support: L1.1",
        ),
        (HEAD + BUILD + "expect: [{collapses: level 5}]\n", "write {at: level 5}", "level 5", "{at: level 5}"),
        (HEAD + BUILD + "expect: [{collapses: true}]\n", "write any", "true", "any"),
        (
            THROW.replace(", from: {bearing: 90 deg}", ""),
            "add `from: {bearing: 30 deg}`",
            "at: L3.1",
            "at: L3.1, from: {bearing: 30 deg}",
        ),
        (
            HEAD + BUILD.replace("{levels: 8}", "{}\n    levels: 8"),
            "`column: {levels: 8}`",
            "{}\n    levels: 8",
            "{levels: 8}",
        ),
        (
            HEAD + BUILD.replace("8", "8, step: '${9 mm + 1}'"),
            "write 1 mm in place of 1",
            "1}",
            "1 mm}",
        ),
        (TWO, "write `at: [0 mm, 0 mm, 11.7 mm]`", "7.8 mm]", "11.7 mm]"),
        (
            HEAD + BUILD.replace("8", "8, friction: 0.3"),
            "in line 3, so remove it here; for the bricks of this step alone, write `brick: "
            "{size: [117.6 mm, 23.4 mm, 7.8 mm], density: 557 kg/m3, friction: 0.3}` beside `column`",
            ", friction: 0.3}",
            "}\n    brick: {size: [117.6 mm, 23.4 mm, 7.8 mm], density: 557 kg/m3, friction: 0.3}",
        ),
        (HEAD + BUILD.replace("8}", "8\n    every: 1 s"), "write '}' at the end of line 5", "8\n", "8}\n"),
        (
            HEAD + "description: Note: a tower\n" + BUILD,
            'write `description: "Note: a tower"`',
            "Note: a tower",
            '"Note: a tower"',
        ),
        (
            HEAD + BUILD + "impacts:\n  - remove: {brick: L12.1}\n",
            "the highest level is 8 (L8.1)",
            "L12.1",
            "L8.1",
        ),
        (
            HEAD.replace("kapla", "{size: [120 mm, 24 mm, 8 mm], density: 12 g}") + BUILD,
            "write `mass: 12 g` in place of `density`",
            "density",
            "mass",
        ),
        (HEAD + BUILD + "expect: [margin: {angle: '>= 3 deg'}]\n", "write `tilt` in place of `angle`", "angle", "tilt"),
        (
            HEAD + "let: {step: 2}\n" + BUILD.replace("8", "8, step: '${step}'"),
            "write 2 mm as the value of 'step' at 4:13",
            "step: 2",
            "step: 2 mm",
        ),
        (HEAD + BUILD + "\tevery: 1 s\n", "indent the line with 4 spaces, like `column` in line 5", "\t", "    "),
    ],
)
def test_a_remedy_followed_to_the_letter_makes_the_scenario_valid(
    text: str, remedy: str, wrong: str, right: str
) -> None:
    assert remedy in only(text).hint
    assert wrong in text
    assert not compiled(text.replace(wrong, right))[1]


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        (HEAD + BUILD + EXPECT + EXPECT, "put the items of both into one `expect`"),
        (HEAD + "systems: [pybullet]\n" + BUILD, "write tuned for PyBullet with settings for stacks, or stock"),
        (HEAD + BUILD + "colour: red\n", "remove it; the keys here are scenario"),
        (HEAD + BUILD + "expect: [margin: {colour: red}]\n", "write one of acceleration, tilt, friction"),
        (HEAD + BUILD + "impacts: [remove: {brick: L3.7}]\n", "level 3 has L3.1"),
        (HEAD + BUILD.replace("8", "8, step: 0.012"), "such as 12 mm for 0.012 m"),
    ],
)
def test_a_remedy_says_what_to_do_with_a_word_that_has_no_counterpart(text: str, remedy: str) -> None:
    assert remedy in only(text).hint


def test_an_include_at_the_top_belongs_in_the_list_of_its_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("_claims.yaml").write_text(EXPECT, encoding="utf-8")
    mistake = only(f"{HEAD}{BUILD}include: _claims.yaml\n")
    assert mistake.hint == "write `- include: _claims.yaml` as an item of `expect`"


def test_an_included_file_that_is_the_list_itself_gets_the_key_of_the_list_that_includes_it(tmp_path: Path) -> None:
    part, scene = tmp_path / "_claims.yaml", tmp_path / "tower.yaml"
    part.write_text("- stands: all\n", encoding="utf-8")
    scene.write_text(f"{HEAD}{BUILD}expect:\n  - include: _claims.yaml\n", encoding="utf-8")
    (mistake,) = gather([scene]).diagnostics
    assert mistake.hint == "write `expect:` above the list and indent the list"
    assert mistake.span.where == f"included from {scene}:7:14"
    part.write_text("expect:\n  - stands: all\n", encoding="utf-8")
    assert not gather([scene]).diagnostics


def test_text_with_a_colon_is_to_be_quoted_where_the_schema_has_text_alone() -> None:
    assert all(
        node.get("type") == "string" and "pattern" not in node
        for path in every_path()
        if path[-1] in TEXT_KEYS
        for node in nodes_at(path)
        if not node.keys() & {"anyOf", "$ref"} and node.get("type") != "null"
    )


def test_keys_beside_an_import_are_told_with_the_whole_import(tmp_path: Path) -> None:
    table = "name,length,width,height,x,y,z,weight\na,400,300,200,0,0,0,5\n"
    tmp_path.joinpath("load.csv").write_text(table, encoding="utf-8")
    scene = tmp_path / "load.yaml"
    keys = "units: {length: mm, mass: kg}", "point: corner"
    head = "scenario: load\nbuild:\n  - import: {file: load.csv"
    scene.write_text(f"{head}}}\n    {keys[0]}\n    {keys[1]}\n", encoding="utf-8")
    whole = f"{{file: load.csv, {', '.join(keys)}}}"
    assert {each.hint for each in gather([scene]).diagnostics} == {
        f"this key belongs in `import`: write `import: {whole}`"
    }
    scene.write_text(f"scenario: load\nbuild:\n  - import: {whole}\n", encoding="utf-8")
    assert not gather([scene]).diagnostics


def required_paths(path: KeyPath = (), depth: int = 7) -> Iterator[KeyPath]:
    """Yield the path of each required key of the language, in mappings and in items of lists."""
    if depth == 0:
        return
    required = {key for node in nodes_at(path) for key in node.get("required", ())}
    for key in keys_at(path):
        if key in required and key != INCLUDE:  # which is replaced before
            yield (*path, key)
        yield from required_paths((*path, key), depth - 1)
        yield from required_paths((*path, key, 0), depth - 1)


def every_path(path: KeyPath = (), depth: int = 5) -> Iterator[KeyPath]:
    """Yield the path of each key of the language, in mappings and in items of lists."""
    for key in keys_at(path) if depth else ():
        yield (*path, key)
        yield from every_path((*path, key), depth - 1)
        yield from every_path((*path, key, 0), depth - 1)


def test_every_example_of_a_required_key_is_valid() -> None:
    paths = [path for path in required_paths() if example_at(path) is not None]
    assert len(paths) > 30
    for path in paths:
        values: object = example_at(path)
        for key in reversed(path):
            values = [values] if isinstance(key, int) else {key: values}
        with pytest.raises(ValidationError) as told:
            models().Scenario.model_validate({**values, "no such key": 1}, context={})  # type: ignore[dict-item]
        wrong = [error for error in told.value.errors() if error["loc"][: len(path)] == path]
        assert not wrong, (path, example_at(path), wrong)
