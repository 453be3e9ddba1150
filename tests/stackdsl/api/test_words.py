"""Python has a function for each word of the language, with its keys, whatever words come to it."""

import ast
import inspect
import re

import pytest

import stackdsl
from stackdsl.api import claims, impacts, layouts, scenario, single_bricks
from stackdsl.api.words import CLAIM_WORDS, IMPACT_WORDS, LAYOUT_WORDS, Words
from stackdsl.language.bricks import PlacedBrick
from stackdsl.language.imports import Import
from stackdsl.language.layouts.column import ColumnParams
from stackdsl.language.layouts.registry import LAYOUTS
from stackdsl.language.schema import models

ALL = pytest.mark.parametrize("words", [CLAIM_WORDS, IMPACT_WORDS, LAYOUT_WORDS], ids=lambda words: words.name)


@ALL
def test_a_stub_says_what_the_functions_are(words: Words) -> None:
    stubs = [part for part in ast.parse(words.stub()).body if isinstance(part, ast.FunctionDef)]
    assert [stub.name for stub in stubs] == words.names()
    for stub in stubs:
        function = words.function(stub.name)
        assert ast.get_docstring(stub, clean=False) == function.__doc__
        parameters = inspect.signature(function).parameters.values()
        assert [one.arg for one in (*stub.args.posonlyargs, *stub.args.kwonlyargs)] == [one.name for one in parameters]


def test_a_layout_takes_its_keys_and_those_of_a_step() -> None:
    taken = set(inspect.signature(layouts.column).parameters)
    step = {"when" if key == "at" else key for key in models().BuildStep.model_fields}
    assert taken == {*ColumnParams.model_fields, *step} - {"repeat", "bricks", "imported", *LAYOUTS}


def test_the_words_of_a_module_are_its_names() -> None:
    assert {"column", "wall", "import_"} & set(dir(layouts)) == {"column", "wall"}
    assert ("stands" in dir(claims), "throw" in dir(impacts)) == (True, True)
    assert layouts.column is layouts.column
    with pytest.raises(AttributeError, match=r"^layouts has no attribute 'colum'; did you mean 'column'\?$"):
        layouts.__getattr__("colum")


def test_a_wrong_parameter_is_told_with_the_one_that_is_meant() -> None:
    with pytest.raises(TypeError, match=r"^layouts.column has no key 'levls'; did you mean 'levels'\?$"):
        layouts.column(**{"levls": 3})  # type: ignore[arg-type, unused-ignore]
    with pytest.raises(TypeError, match=r"^column\(\) takes 0 positional arguments but 1 was given"):
        layouts.column(3)  # type: ignore[arg-type, call-arg, misc, unused-ignore]


def test_a_scenario_takes_the_keys_of_the_language() -> None:
    taken = {name for name in inspect.signature(scenario.Scenario).parameters if name != "name"}
    assert taken | {"scenario", "extends"} == set(models().Scenario.model_fields)  # Python has functions


def test_a_brick_takes_the_keys_of_the_language() -> None:
    assert set(inspect.signature(single_bricks.brick).parameters) == set(PlacedBrick.model_fields) - {"repeat"}
    step = {"each" if key == "bricks" else "when" if key == "at" else key for key in models().BuildStep.model_fields}
    assert set(inspect.signature(single_bricks.bricks).parameters) == step - {"repeat", "until", "imported", *LAYOUTS}
    taken = set(inspect.signature(single_bricks.imported).parameters)
    assert taken == {*Import.model_fields, *step} - {"repeat", "until", "imported", "each", "brick", *LAYOUTS}


@pytest.mark.parametrize(("name", "call"), [("stable", 'claims.stands("all")'), ("topples", 'claims.collapses("any")')])
def test_an_unknown_claim_is_told_with_the_whole_call_of_its_meaning(name: str, call: str) -> None:
    with pytest.raises(AttributeError, match=re.escape(f"write {call}")):
        getattr(claims, name)


@pytest.mark.parametrize(("name", "home"), [("column", "layouts"), ("stands", "claims"), ("remove", "impacts")])
def test_a_name_of_a_module_of_the_package_is_told_with_this_module(name: str, home: str) -> None:
    with pytest.raises(AttributeError, match=rf"from stackdsl import {home}`, then `{home}\.{name}\("):
        getattr(stackdsl, name)
