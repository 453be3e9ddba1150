"""Python has a function for each word of the language, with its keys, whatever words come to it."""

import inspect
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import pytest

from stackdsl.api import scenario, single_bricks
from stackdsl.language.bricks import PlacedBrick
from stackdsl.language.imports import Import
from stackdsl.language.schema import models
from tests.paths import ROOT

WRITES = ROOT / "tools" / "python_words.py"


def writer() -> ModuleType:
    spec = spec_from_file_location("python_words", WRITES)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def functions(text: str) -> list[tuple[str, str]]:
    """Each function of a module, whatever its layout of lines: its name, and its text without white space."""
    parts = text.split("\ndef ")[1:]
    return [(part.split("(")[0], "".join(part.replace(",\n", "\n").split())) for part in parts]


@pytest.mark.parametrize(("path", "text"), list(writer().texts()), ids=lambda value: getattr(value, "name", ""))
def test_the_functions_are_those_of_the_language(path: Path, text: str) -> None:
    loose = [(name, body.replace(",", "")) for name, body in functions(text)]
    committed = [(name, body.replace(",", "")) for name, body in functions(path.read_text(encoding="utf-8"))]
    assert committed == loose, "write them anew with `make words`"


def test_a_scenario_takes_the_keys_of_the_language() -> None:
    taken = {name for name in inspect.signature(scenario.Scenario).parameters if name != "name"}
    assert taken | {"scenario", "extends"} == set(models().Scenario.model_fields)  # Python has functions


def test_a_brick_takes_the_keys_of_the_language() -> None:
    assert set(inspect.signature(single_bricks.brick).parameters) == set(PlacedBrick.model_fields) - {"repeat"}
    step = {"each" if key == "bricks" else "when" if key == "at" else key for key in models().BuildStep.model_fields}
    from stackdsl.language.layouts.registry import LAYOUTS  # noqa: PLC0415 -- all registered by now

    assert set(inspect.signature(single_bricks.bricks).parameters) == step - {"repeat", "until", "imported", *LAYOUTS}
    taken = set(inspect.signature(single_bricks.imported).parameters)
    assert taken == {*Import.model_fields, *step} - {"repeat", "until", "imported", "each", "brick", *LAYOUTS}
