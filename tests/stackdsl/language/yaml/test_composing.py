"""`extends` and `include`: values from other files, places of mistakes, limits."""

from pathlib import Path

import pytest

from stackdsl.checking.cases import Case, gather
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.yaml import includes
from stackdsl.language.yaml.includes import MAX_TRAIL

BASE = """
scenario: base
tags: [tower]
brick: {size: [120 mm, 24 mm, 8 mm], density: 500 kg/m3}
world: {gravity: 1.62 m/s2, ground: {friction: 0.6}}
let: {levels: 3, every: 1 s}
build:
  - column: {levels: "${levels}"}
    every: ${every}
expect:
  - stands: all
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The root of a project, which is where commands are given."""
    (tmp_path / "inside").mkdir()
    (tmp_path / "inside" / "stackdsl.toml").touch()
    monkeypatch.chdir(tmp_path / "inside")
    return tmp_path / "inside"


def write(**files: str) -> None:
    """Files of YAML, by name; two underscores stand for a folder."""
    for name, text in files.items():
        file = Path(name.replace("__", "/") + ".yaml")
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")


def cases(file: str = "a.yaml") -> list[Case]:
    gathered = gather([Path(file)])
    assert gathered.diagnostics == ()
    return list(gathered.cases)


def mistakes(file: str = "a.yaml") -> list[Diagnostic]:
    return list(gather([Path(file)]).diagnostics)


pytestmark = pytest.mark.usefixtures("project")


def test_missing_keys_come_from_the_extended_scenario() -> None:
    write(
        base=BASE,
        a="scenario: a\nextends: base.yaml\nlet: {levels: 5}\nworld: {gravity: 1 g0}\nexpect: [{drift: 0 mm}]",
    )
    (case,) = cases()
    world = case.timeline.world
    assert (len(case.timeline.placements), case.timeline.built) == (5, 4.0)
    assert (world.gravity, world.planes[0].friction) == (9.80665, 0.6)  # the world is merged key by key
    assert [claim.kind for claim in case.scenario.expect] == ["drift"]  # lists are replaced
    assert case.scenario.tags == ("tower",)


def test_scenarios_of_one_file_extend_each_other_and_files_of_several_are_asked_which() -> None:
    write(
        a=f"{BASE}---\nscenario: a\nextends: {{scenario: base}}\nlet: {{levels: 4}}", b="scenario: b\nextends: a.yaml"
    )
    assert [len(case.timeline.placements) for case in cases()] == [3, 4]
    (mistake,) = mistakes("b.yaml")
    assert (mistake.code, str(mistake.span)) == ("SD113", "b.yaml:2:10")
    assert "contains 2 scenarios" in mistake.message
    write(b="scenario: b\nextends: {file: a.yaml, scenario: a}\nfriction: 0.1")
    assert [len(case.timeline.placements) for case in cases("b.yaml")] == [4]
    write(b="scenario: b\nextends: {file: a.yaml, scenario: c}")
    assert "has no scenario 'c'" in mistakes("b.yaml")[0].message


def test_lists_take_the_items_of_the_list_of_that_name_in_another_file() -> None:
    write(
        parts___base="build:\n  - column: {levels: 2}\n    every: 1 s\nexpect:\n  - stands: all\n  - drift: 0 mm\n",
        parts___pair="bricks: [{at: [0, 0, 19.5 mm]}, {name: top, at: [0, 0, 27.3 mm]}]",
        a="""
scenario: a
build:
  - include: parts/_base.yaml
  - bricks:
      - include: parts/_pair.yaml
      - {name: beside, at: [1 m, 0, 3.9 mm]}
    every: 1 s
expect:
  - include: parts/_base.yaml
  - height: {of: top, is: 31.2 mm ± 0.1 mm}
""",
    )
    (case,) = cases()
    assert [placed.brick.id for placed in case.timeline.placements] == ["L1.1", "L2.1", "L3.1", "top", "beside"]
    assert [claim.kind for claim in case.scenario.expect] == ["stands", "drift", "height"]
    assert set(case.source.parts) == {"parts/_base.yaml", "parts/_pair.yaml"}


def test_a_base_that_others_extend_is_no_scenario() -> None:
    write(_part="build: []", a=BASE)
    assert [case.scenario.scenario for case in gather([Path()]).cases] == ["base"]


def test_a_mistake_is_told_in_the_file_in_which_it_is_and_from_where_that_is_taken() -> None:
    write(_part="# a part\nbuild:\n  - column: {levels: 0}\n", a="scenario: a\nbuild:\n  - include: _part.yaml\n")
    (mistake,) = mistakes()
    assert (str(mistake.span), mistake.span.where) == ("_part.yaml:3:22", "included from a.yaml:3:5")
    write(base=BASE.replace("500 kg/m3", "500"), b="\nscenario: b\nextends: base.yaml")
    (mistake,) = mistakes("b.yaml")
    assert (str(mistake.span), mistake.span.where) == ("base.yaml:4:47", "extended from b.yaml:3:1")
    assert len(mistakes(".")) == 2  # each once, whoever takes it


def test_an_included_step_may_be_repeated_and_names_its_repetition() -> None:
    write(
        _part="build:\n  - repeat: {x: 1 .. 3}\n    column: {levels: '${x - 2}', origin: ['${x * 1 m}', 0, 0]}\n",
        a="scenario: a\nbuild:\n  - include: _part.yaml\n",
    )
    assert mistakes()[0].span.where == "x = 1, included from a.yaml:3:5"


def test_variables_that_a_scenario_takes_over_may_be_left_unused() -> None:
    write(base=BASE, a="scenario: a\nextends: base.yaml\nbuild: [{column: {levels: 2}}]")
    assert len(cases()) == 1
    write(a="scenario: a\nextends: base.yaml\nbuild: [{column: {levels: 2}}]\nlet: {levels: 7}")
    assert [mistake.code for mistake in mistakes()] == ["SD112"]


KINDS = "brick_types: {slab: {size: [9 mm, 9 mm, 9 mm], mass: 1 g}}\n"


def test_kinds_of_bricks_that_a_scenario_takes_over_may_be_left_unused() -> None:
    write(base=BASE + KINDS, a="scenario: a\nextends: base.yaml\n")
    assert len(cases()) == 1
    write(a=f"scenario: a\nextends: base.yaml\n{KINDS}")
    assert [str(mistake.span) for mistake in mistakes()] == ["a.yaml:3:15"]


def test_a_scenario_that_others_of_its_file_extend_may_offer_kinds_of_bricks_to_them() -> None:
    write(a=f"{BASE}{KINDS}---\nscenario: a\nextends: {{scenario: base}}\nbrick: slab\n")
    assert len(cases()) == 2


def test_an_included_step_may_use_a_kind_of_brick() -> None:
    write(_part="build: [{column: {levels: 2}, brick: slab}]", a=f"scenario: a\n{KINDS}build: [include: _part.yaml]\n")
    assert len(cases()) == 1


def test_a_kind_of_brick_that_a_matrix_chooses_is_used() -> None:
    write(a=f"scenario: a\n{KINDS}matrix: {{kind: [slab, kapla]}}\nbrick: ${{kind}}\nbuild: [column: {{levels: 2}}]\n")
    assert len(cases()) == 2


def test_an_ambiguous_word_in_a_base_of_the_same_file_stops_both_scenarios() -> None:
    write(a=f"{BASE}description: yes\n---\nscenario: a\nextends: {{scenario: base}}\n")
    gathered = gather([Path("a.yaml")])
    assert gathered.cases == ()
    assert [(mistake.code, mistake.hint) for mistake in gathered.diagnostics] == [("SD009", 'quote it: "yes"')]


def test_a_missing_file_is_not_mistaken_for_the_file_that_names_it() -> None:
    write(a="scenario: a\nbuild: [include: _a.yaml]\n")
    assert mistakes()[0].hint == "check the path, which is relative to the folder of this file"
    write(part="build: [column: {levels: 2}]\n", a="scenario: a\nbuild: [include: _part.yaml]\n")
    assert mistakes()[0].hint == "did you mean 'part.yaml'?"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("/etc/passwd", "absolute path"),
        ("~/base.yaml", "absolute path"),
        ("C:/base.yaml", "absolute path"),
        ("../outside.yaml", "is outside the project"),
        ("x/../../outside.yaml", "is outside the project"),
        ("link.yaml", "is outside the project"),
        ("folder/outside.yaml", "is outside the project"),
        ("gone.yaml", "the file gone.yaml does not exist"),
        ("pipe.yaml", "not a regular file"),
        ("loop.yaml", "does not exist"),
        (".", "not a regular file"),
    ],
)
@pytest.mark.parametrize("form", ["extends: {}", "extends: {{file: {}}}", "build: [{{include: {}}}]"])
def test_files_outside_the_project_are_rejected(project: Path, name: str, words: str, form: str) -> None:
    (project.parent / "outside.yaml").write_text(BASE, encoding="utf-8")
    (project / "link.yaml").symlink_to(project.parent / "outside.yaml")
    (project / "loop.yaml").symlink_to("loop.yaml")
    (project / "folder").symlink_to(project.parent)
    import os  # noqa: PLC0415 -- for the one thing that pathlib cannot make

    os.mkfifo(project / "pipe.yaml")
    write(a=f"scenario: a\n{form.format(name)}\n")
    (mistake,) = mistakes()
    assert (mistake.code, mistake.span.line) == ("SD113", 2)
    assert words in mistake.message
    assert mistake.hint


def test_a_way_up_and_a_link_inside_of_the_project_are_fine(project: Path) -> None:
    write(base=BASE, sub__a="scenario: a\nextends: ../base.yaml\n")
    assert len(cases("sub/a.yaml")) == 1
    (project / "sub" / "near.yaml").symlink_to("../base.yaml")
    write(sub__a="scenario: a\nextends: near.yaml\n")
    assert len(cases("sub/a.yaml")) == 1


def test_without_a_mark_the_root_is_the_folder_of_the_file(project: Path) -> None:
    (project / "stackdsl.toml").unlink()
    write(base=BASE, sub__a="scenario: a\nextends: ../base.yaml\n")
    (mistake,) = mistakes("sub/a.yaml")
    assert "is outside" in mistake.message
    assert "stackdsl.toml" in mistake.hint


def test_a_circle_is_named() -> None:
    write(a="scenario: a\nextends: b.yaml", b="scenario: b\nextends: c.yaml", c="scenario: c\nextends: a.yaml")
    assert "a.yaml -> b.yaml -> c.yaml -> a.yaml" in mistakes()[0].message
    write(a="scenario: a\nextends: {scenario: a}")
    assert "a.yaml -> a.yaml" in mistakes()[0].message
    write(a="scenario: a\nbuild: [{include: p.yaml}]", p="build: [{include: p.yaml}]")
    assert "a.yaml -> p.yaml -> p.yaml" in mistakes()[0].message


def test_nesting_of_includes_is_limited() -> None:
    write(**{f"f{n}": f"scenario: f{n}\nextends: f{n + 1}.yaml" for n in range(MAX_TRAIL + 2)})
    (mistake,) = mistakes("f0.yaml")
    assert f"more than {MAX_TRAIL} deep" in mistake.message


def test_exponential_includes_are_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of ten files takes the next one ten times: 10^10 steps."""
    monkeypatch.setattr(includes, "MAX_TAKEN", 20_000)
    write(**{f"f{n}": f"build: [{', '.join([f'{{include: f{n + 1}.yaml}}'] * 10)}]" for n in range(9)})
    write(f9=f"build: [{', '.join(['{column: {levels: 1}}'] * 1000)}]", a="scenario: a\nbuild: [{include: f0.yaml}]")
    (mistake,) = mistakes()
    assert (mistake.code, "more than 20000 values" in mistake.message) == ("SD206", True)
    write(f9="build: [{column: {levels: 1}}]")
    (mistake,) = mistakes()
    assert (mistake.code, "more than 1000 keys `extends`" in mistake.message) == ("SD206", True)


def test_many_large_files_are_too_much_together() -> None:
    padding = f"build: [{{column: {{levels: 1}}}}]\n{'#' * 600_000}\n"
    write(p=padding, q=padding, a="scenario: a\nbuild: [{include: p.yaml}, {include: q.yaml}]")
    (mistake,) = mistakes()
    assert (mistake.code, "exceed 1 MiB" in mistake.message) == ("SD206", True)


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("extends: 5", "SD103", "expected the path of a file"),
        ("extends: {fil: base.yaml}", "SD103", "expected the path of a file"),
        ("extends: {scenario: 5}", "SD103", "name of a scenario"),
        ("extends: '${x}.yaml'", "SD103", "path of a file"),
        ("build: [{include: base.yaml, every: 1 s}]", "SD108", "cannot have other keys"),
        ("impacts: [{include: base.yaml}]", "SD113", "has no list `impacts`"),
        ("build: [{include: broken.yaml}]", "SD004", "is missing"),
        ("build: [{include: {file: base.yaml}}]", "SD103", "path of a file"),
    ],
)
def test_invalid_includes_are_rejected(text: str, code: str, words: str) -> None:
    write(base=BASE, broken="build: [", a=f"scenario: a\n{text}\n")
    assert (code, True) in [(mistake.code, words in mistake.message) for mistake in mistakes()]
