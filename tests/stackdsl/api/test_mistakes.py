"""Mistakes in Python: each names the key that it is of, and its remedy is Python."""

import copy
import pickle
import re
import sys
from collections.abc import Callable
from dataclasses import FrozenInstanceError
from html import unescape
from inspect import currentframe
from pathlib import Path
from typing import Any

import pytest

import stability
import stackdsl
from stackdsl.api import claims, impacts, layouts
from stackdsl.api.cases import ScenarioError, load, loads
from stackdsl.api.run import play
from stackdsl.api.scenario import Scenario
from stackdsl.api.single_bricks import brick, bricks
from stackdsl.api.studies import find, margins, sensitivities, survive
from stackdsl.api.written import Written

ANY: Any = True
NOTHING: Any = None  # which a type checker would refuse


def column(levels: int = 3, step: object = None, every: str | None = None, when: str | None = None) -> Written:
    return layouts.column(levels=levels, step=step, every=every, when=when)  # type: ignore[arg-type, unused-ignore]


@pytest.mark.parametrize(
    ("keys", "key", "remedy"),
    [
        ({"build": [column(step="12")]}, "column.step", 'write a length with its unit, such as "12 mm"'),
        ({"build": [column(when="0,5 s")]}, "when", "replace the decimal comma by a point: 0.5 s"),
        ({"build": column()}, "build", "put it into a list, [...]: steps of building, in order"),
        ({"build": [column(step="${shift}")]}, "column.step", "define it in `let={...}`"),
        ({"build": [bricks([brick(at=["0 mm", "x", "0 mm"])])]}, "at[1]", 'write a length with its unit, such as "'),
        ({"friction": "rough"}, "friction", "write 0 to 10"),
        ({"tags": "tall"}, "tags", 'write ["tall"]: keywords for selecting scenarios'),
        ({"systems": ["tune"]}, "systems[0]", "did you mean 'tuned'?"),
        ({"world": {"gravty": "1 m/s2"}}, "world.gravty", "did you mean 'gravity'?"),
        ({"expect": ["stands"]}, "expect[0]", 'write claims.stands("all")'),
        ({"expect": [claims.stands(ANY)]}, "stands", 'write "all"'),
        ({"expect": [claims.stands()]}, "stands", 'write "all", or add one of the keys levels, bricks, for_'),
        ({"impacts": [impacts.remove(brick="L9.1")]}, "remove.brick", "the highest level is 3 (L3.1)"),
        ({"name": "Two Words"}, "name", "use lower-case letters, digits and -"),
    ],
)
def test_a_mistake_names_its_key_and_what_to_write_in_python(keys: dict[str, Any], key: str, remedy: str) -> None:
    with pytest.raises(ScenarioError) as told:
        Scenario(**{"name": "column", "build": [column()], **keys}).play()
    (found,) = told.value.diagnostics
    assert found.span.key == key
    assert f"`{key}`: " in str(told.value)
    assert remedy in found.hint


def test_two_mistakes_in_one_line_are_two() -> None:
    with pytest.raises(ScenarioError) as told:
        Scenario("column", build=[column(step="12", every="12")]).play()
    assert {found.span.key for found in told.value.diagnostics} == {"column.step", "every"}


def test_what_is_no_value_is_told_with_its_key() -> None:
    with pytest.raises(TypeError, match=r"`build\[1\]` must be a string"):
        Scenario("column", build=[column(), NOTHING])
    with pytest.raises(TypeError, match=r"`column\.step` must be a string"):
        column(step=object())


SCENARIO = Scenario("column", build=[column()])


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: play("a.yaml"), r"expected a Scenario, or .* not a str; read a file with stackdsl.load\('a.yaml'\)"),  # type: ignore[arg-type]
        (lambda: find({"scenario": "a"}, largest="step"), r"not a dict; write Scenario\(name, build="),  # type: ignore[arg-type]
        (lambda: survive(SCENARIO.play()), "not a Run; a run has its case as `run.case`"),  # type: ignore[arg-type]
        (lambda: sensitivities([SCENARIO]), "one of them is a Scenario; give the cases of a scenario"),  # type: ignore[list-item]
        (lambda: survive(SCENARIO, bearings="many"), "bearings must be a whole number from 4 to 3600"),  # type: ignore[arg-type]
        (lambda: find(SCENARIO, largest="step", to=5), "to must be a text with a unit, such as '5 mm', not 5"),  # type: ignore[arg-type]
        (lambda: sensitivities(SCENARIO, check="all"), "check must be a whole number from 0"),  # type: ignore[arg-type]
        (lambda: Scenario("a", build=[layouts.column]), r"call it: column\(\.\.\.\)"),  # type: ignore[list-item]
        (lambda: load("scenario: a\nbuild:"), "not its text; `stackdsl.loads` reads a text"),
        (lambda: loads("a.yaml"), r"not the path of a file; write stackdsl.load\('a.yaml'\)"),
        (lambda: Scenario("a", build=[brick(name="a")]), r"`build\[0\]` is .*; .* as in build=\[bricks\(\[brick\("),
        (lambda: Scenario("a", build=[column()], expect=[column()]), "a step of building belongs in `build`"),
        (lambda: Scenario("a", build=[column()], **{"expects": ANY}), "argument 'expects'; did you mean 'expect'"),
        (lambda: Scenario("a"), r"such as Scenario\(.tower., build=\[layouts.column\(levels=3\)\]\)"),  # type: ignore[call-arg]
        (lambda: survive(SCENARIO, bearing=36), "did you mean 'bearings'"),  # type: ignore[call-arg]
        (lambda: SCENARIO.play(3), "expected a part of a variant, .* not int"),  # type: ignore[arg-type]
        (lambda: SCENARIO.play().judge("stands"), r"expected a claim, such as claims\.stands\(.all.\)"),  # type: ignore[arg-type]
    ],
)
def test_what_is_of_another_kind_is_refused_with_what_was_expected(call: Callable[[], object], told: str) -> None:
    with pytest.raises(TypeError, match=told):
        call()


def test_a_function_of_one_case_takes_a_scenario_of_one_case_and_names_the_cases_of_others() -> None:
    assert find(SCENARIO, largest="levels").case == "column[exact]"
    several = Scenario("several", build=[column()], matrix={"friction": [0.3, 0.5]}, friction="${friction}")
    with pytest.raises(LookupError, match=r"there are 2: several\[.*\]; choose one, such as `scenario.cases\[0\]`"):
        survive(several)


@pytest.mark.parametrize(
    ("value", "name", "told"),
    [
        (SCENARIO.play, "margins", r"write `margins\(run.case\)`"),
        (SCENARIO.play, "replay", "write `run` as the last line of a cell"),
        (SCENARIO.play, "verdikt", "did you mean 'verdict'"),
        (SCENARIO.play, "stands", r"write `run.judge\(claims.stands\(...\)\)`"),
        (lambda: SCENARIO, "save", r"write_text\(scenario.to_yaml\(\)\)"),
        (lambda: margins(SCENARIO), "tlit", "choose from: .* tilt"),
        (lambda: stackdsl, "simulate", "did you mean 'play'"),
        (lambda: layouts, "colum", r"did you mean 'column'\?$"),
        (lambda: SCENARIO, "plot", r"shows the replay of the run `scenario.play\(\)`"),
        (lambda: SCENARIO, "table", r"write `scenario.play\(\).table`"),
        (lambda: SCENARIO.cases[0], "play", r"write `play\(case\)`"),
    ],
)
def test_an_attribute_that_is_elsewhere_is_told_with_what_to_write(
    value: Callable[[], object], name: str, told: str
) -> None:
    with pytest.raises(AttributeError, match=told):
        getattr(value(), name)


@pytest.mark.parametrize(("name", "meant"), [("Scenrio", "Scenario"), ("simulate", "play")])
def test_a_wrong_name_in_an_import_is_answered_by_the_one_that_is_meant(name: str, meant: str) -> None:
    with pytest.raises(ImportError, match=rf"cannot import '{name}' from 'stackdsl'; did you mean '{meant}'\?"):
        exec(f"from stackdsl import {name}")


@pytest.mark.parametrize("name", ["run", "check"])
def test_a_word_of_the_command_line_is_answered_by_the_functions_that_do_it(name: str) -> None:
    with pytest.raises(ImportError, match=r"write `from stackdsl import load, play`, then `play\(load\("):
        exec(f"from stackdsl import {name}")


def test_a_variant_that_is_not_unique_is_answered_by_the_variants() -> None:
    with pytest.raises(LookupError, match=r"no case has 'tuned' .* variants are exact; .* write systems=\['tuned'\]"):
        SCENARIO.play("tuned")
    both = Scenario("both", build=[column()], systems=["exact", "tuned"])
    with pytest.raises(LookupError, match=r"there are 2 cases: exact, tuned; name one, such as play\('exact'\), or"):
        both.play()


def test_values_can_still_be_copied_and_pickled() -> None:
    assert pickle.loads(pickle.dumps(SCENARIO.cases[0])).name == "column[exact]"
    assert copy.copy(SCENARIO.play()).verdict == "stands"


def test_margins_of_statics_send_a_scenario_to_margins_of_cases() -> None:
    with pytest.raises(TypeError, match=r"for a scenario write `stackdsl.margins\(scenario\)`"):
        stability.margins(SCENARIO)  # type: ignore[arg-type]


def test_a_missing_package_is_told_with_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install pandas`, or write `table\.to_csv"):
        SCENARIO.play().to_pandas()


def test_a_table_has_columns_and_prints() -> None:
    table = SCENARIO.play().table()
    assert table.columns[:3] == ["name", "level", "state"]
    assert table.column("level").tolist() == [1, 2, 3]
    assert table.column("z_mm") == pytest.approx([3.9, 11.7, 19.5])
    assert str(table).splitlines()[1].split()[:3] == ["L1.1", "1", "frozen"]
    with pytest.raises(LookupError, match="unknown column 'height'; the columns are name, level"):
        table.column("height")


VARIABLES = """scenario: leaning
let: {step: 12 mm}
matrix: {levels: [3, 9]}
build:
  - column: {levels: "${levels}", step: "${step}"}
"""


def test_load_gives_variables_other_values_which_the_names_of_the_cases_have(tmp_path: Path) -> None:
    file = tmp_path / "leaning.yaml"
    file.write_text(VARIABLES, encoding="utf-8")
    assert [case.name for case in load(file, step="14 mm")] == [
        "leaning[levels=3,step=14mm,exact]",
        "leaning[levels=9,step=14mm,exact]",
    ]
    (case,) = loads(VARIABLES, step="14 mm", levels=9)
    assert (case.name, str(play(case).verdict)) == ("leaning[levels=9,step=14mm,exact]", "collapses")
    assert play(case).judge(claims.collapses(at="level 9")).passed
    with pytest.raises(TypeError, match=r"no scenario in text has a variable 'stpe'; did you mean 'step'\?"):
        loads(VARIABLES, stpe="14 mm")
    with pytest.raises(TypeError, match="has a variable 'gap'; variables: levels, step"):
        loads(VARIABLES, gap="14 mm")


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"step": 14}, "step=14 has no unit; write step='14 mm'"),
        ({"step": "14 kg"}, "step='14 kg' has another kind of unit than '12 mm' in the file; write step='14 mm'"),
        ({"step": "14 foo"}, "write step='14 mm'"),
        ({"levels": "9 mm"}, "levels='9 mm' has a unit, but 'levels' is a number without a unit; write levels=9"),
    ],
)
def test_a_value_of_another_kind_is_told_at_the_argument(values: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=re.escape(told)):
        loads(VARIABLES, **values)
    assert loads(VARIABLES, step=0, levels="9")[0].name == "leaning[levels=9,step=0,exact]"


def test_a_value_given_to_load_has_its_place_in_the_program_and_no_command_selects_its_case(tmp_path: Path) -> None:
    file = tmp_path / "leaning.yaml"
    file.write_text(f"{VARIABLES}expect: [stands: all]", encoding="utf-8")
    case = load(file, step="18 mm")[1]
    line = currentframe().f_lineno - 1  # type: ignore[union-attr]
    place = find(case, largest="step").place
    assert place.partition(":")[2] == f"{line}:5"
    run = play(case)
    assert run.cause.see == "print(run.cause)"
    assert f"now 18 mm, {place}" in unescape(run._repr_mimebundle_()["text/html"])
    as_written = load(file)[1]
    assert play(as_written).cause.see == f"stackdsl explain {file} -k 'leaning[levels=9,exact]'"


def test_a_limit_prints_as_a_sentence_and_is_a_number() -> None:
    found = find(loads(VARIABLES, levels=9)[0], largest="step")
    assert str(found).startswith("leaning[levels=9,exact]: largest step 13.06 mm stands, 13.07 mm falls; ")
    assert found.limit == pytest.approx(117.6 / 9)
    assert find(loads(VARIABLES, levels=9)[0], least="friction").limit is None  # flat bricks need none


def test_an_unknown_keyword_of_find_is_told_with_the_remedy() -> None:
    with pytest.raises(TypeError, match=r"find got .* keyword argument 'step'; name the number as largest=, least= or"):
        find(loads(VARIABLES)[0], step="18 mm")  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("name", "remedy"),
    [("step", "load(path, step=...)"), ("tilt", "load(path, levels=...)"), ("system", "case.on('tuned')")],
)
def test_a_case_cannot_be_changed_and_the_error_says_what_to_write(name: str, remedy: str) -> None:
    with pytest.raises(FrozenInstanceError, match=re.escape(remedy)):
        setattr(loads(VARIABLES)[0], name, "tuned")
