"""Models of a scenario: values, defaults, and JSON schema."""

import json
import re
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from pydantic import TypeAdapter, ValidationError

from stackdsl.language.bricks import CATALOGUE, BrickKind, cut_to, known_bricks
from stackdsl.language.claims.collapses import Collapses
from stackdsl.language.claims.drift import Drift
from stackdsl.language.claims.penetration import Penetrates
from stackdsl.language.claims.rests_on import RestsOn
from stackdsl.language.claims.stands import Stands
from stackdsl.language.claims.sway import Sways
from stackdsl.language.json_schema import json_schema, keys_at, schema_text
from stackdsl.language.layouts.column import ColumnParams
from stackdsl.language.layouts.registry import LAYOUTS
from stackdsl.language.schema import UNTIL_COLLAPSE, Scenario, models
from stackdsl.language.tolerances import Tolerance
from stackdsl.language.value_types import SYSTEMS
from stackdsl.language.variants import expand
from stackdsl.language.yaml.source import parse
from tests.paths import ROOT

EVERYTHING = """
scenario: everything
description: Uses every key of the language.
tags: [example]
brick_types: {slab: {size: [60 mm, 24 mm, 8 mm], mass: 6 g}}
brick: {size: [120 mm, 24 mm, 8 mm], density: 500 kg/m3}
friction: 0.4
world:
  gravity: 1 g0
  ground: {friction: 0.6}
  walls: [{bearing: 90 deg, distance: 0.5 m, friction: 0}]
  tilt: {angle: 2 deg, towards: 90 deg}
let:
  half: ${step / 2}
matrix:
  step: [10 mm, 12 mm]
  n: 1 .. 2
cases:
  - {name: short, reach: 3 m}
  - {name: far, reach: 4 m}
exclude:
  - {name: short, n: 2}
build:
  - four_stack: {levels: 4, step: "${half}", spacing: 90 mm, origin: [0 mm, 0 mm, 0 mm], heading: 45 deg}
    name: tower
    every: 1 s
  - column: {levels: "${2 * n}", step: "${step}", origin: [1 m, 0 m, 0 m]}
    brick: kapla-ideal
    at: 2 s
  - wall: {levels: 3, bricks: 4, gap: 0.5 mm, origin: [0 m, 1 m, 0 m]}
    after: level 3 + 1 s
  - harmonic: {bricks: 5, share: 0.9, origin: [2 m, 0 m, 0 m]}
    after: built
  - tower: {levels: 3, bricks: 16, overlap: 40 %, origin: [5 m, 0 m, 0 m]}
  - card_house: {levels: 2, angle: 70 deg, spacing: 120 mm, origin: [6 m, 0 m, 0 m]}
    name: cards
  - bricks:
      - {name: roof, at: [0 mm, 0 mm, 100 mm], rotate: [0 deg, 0 deg, 90 deg], drop: true, level: 5}
      - {at: ["${reach}", 0 m, 4 mm], brick: slab}
      - {name: peg, on: ground, offset: [9 m, 0, 0]}
      - {beside: peg, towards: 90 deg, brick: slab}
      - {repeat: {i: 1 .. 3, j: "1 .. ${n}"}, at: ["${10 m + i * 1 m}", "${j * 1 m}", 4 mm]}
    after: brick L2.1 + 500 ms
  - leaning_structure: {step: 12 mm, spacing: 80 mm, origin: [7 m, 0 m, 0 m]}
    every: 1 s
    until: collapse
impacts:
  - remove: {brick: L2.1}
    at: 4 s
  - remove: {bricks: [L1.1, L1.2]}
    after: built + 2 s
  - repeat: {k: 3 .. 1 by -1}
    every: 500 ms
    push: {brick: "L${k}.2", impulse: [1 mN*s, 0 N*s, 0 N*s]}
  - insert: {at: [4 m, 0 m, 4 mm], rotate: [0 deg, 0 deg, 90 deg], brick: kapla-ideal, name: wedge, level: 1}
    after: impact 2 + 1 s
  - throw:
      {name: shot, brick: kapla, at: level 4, turn: 90 deg, speed: 2 m/s, from: {bearing: 30 deg, distance: "${step}"}}
  - throw: {at: L4.1, from: {bearing: 90 deg}, speed: "${100 * step / 1 s}"}
  - push: {brick: L4.2, impulse: [1 mN*s, 0.01 N*s, "${1 kg * 1 m / 1 s}"], point: [0 mm, 0 mm, 3.9 mm]}
  - drop: {name: hammer, brick: kapla, onto: level 4, height: 100 mm, rotate: [0 deg, 90 deg, 0 deg]}
  - drop: {onto: L4.1, height: 0.1 m}
xfail: {reason: it is an example, strict: false, system: [tuned]}
skip: {reason: it is an example, system: stock}
systems: [thesis, tuned, stock]
expect:
  - stands: all
    system: thesis
  - stands: {levels: 4, bricks: [roof, L1.1], for: 3 s}
  - collapses: any
    system: stock
  - collapses: {at: level 9 ± 1, brick: L9.1, time: 9 s .. 11 s}
    system: [tuned, stock]
  - displaced: {bricks: <= 2, by: "> 5 mm"}
  - drift: < 2 mm
  - drift: {is: 1 ± 0.5 mm, bricks: [roof]}
  - rests_on: {brick: roof, support: L4.1, share: 50 % ± 2 %}
  - rests_on: {brick: L1.1, support: ground}
  - height: ">= 100 mm"
  - height: {is: 104 mm ± 1 mm, of: roof}
  - sway: {amplitude: <= 0.1 mm, frequency: 1 Hz .. 5 Hz}
  - penetration: <= 0.1 mm
truth:
  - stands: {levels: 3}
    source: closed form
    because: nothing leans
"""


def variants(text: str) -> list[dict[str, Any]]:
    loaded = parse(text, "a.yaml")
    assert loaded.diagnostics == ()
    found, diagnostics = expand(loaded.sources[0])
    assert diagnostics == ()
    return [variant.values for variant in found]


def validated(values: dict[str, Any]) -> Scenario:
    return models().Scenario.model_validate(values, context=known_bricks(values.get("brick_types"), {}))


def scenario(text: str) -> Scenario:
    return validated(variants(text)[0])


def brick(written: object) -> BrickKind:
    return TypeAdapter(BrickKind).validate_python(written)


def between(low: float, high: float, text: str) -> Tolerance:
    return Tolerance(low, high, low_open=False, high_open=False, text=text)


def test_minimal_scenario_has_defaults() -> None:
    least = scenario("{scenario: least, build: [{column: {levels: 3}}]}")
    assert least.brick.size == CATALOGUE["kapla"].size
    assert (least.friction, least.world.gravity, least.world.ground.friction) == (0.5, 9.81, None)
    assert (least.world.walls, least.world.tilt.angle, least.world.tilt.towards) == ((), 0.0, 0.0)
    assert (least.systems, least.expect, least.truth) == (("exact",), (), ())


def test_scenario_with_every_key_is_valid() -> None:
    first, *_, last = map(validated, variants(EVERYTHING))
    tower, column, _, _, _, _, single, leaning = first.build
    assert tower.layout == ("four_stack", tower.four_stack)  # type: ignore[attr-defined]
    origin = ["1 m", "0 m", "0 m"]
    assert column.layout == ("column", ColumnParams.model_validate({"levels": 2, "step": "1 cm", "origin": origin}))
    assert single.layout is None
    assert single.bricks is not None
    assert (single.bricks[0].name, single.bricks[0].drop, single.bricks[0].level) == ("roof", True, 5)
    assert leaning.layout is not None
    assert (leaning.until, leaning.layout[1].levels) == ("collapse", UNTIL_COLLAPSE)  # type: ignore[attr-defined]
    assert [expectation.kind for expectation in first.expect] == [
        *["stands"] * 2, *["collapses"] * 2, "displaced", *["drift"] * 2, *["rests_on"] * 2, *["height"] * 2,
        "sway", "penetration",
    ]  # fmt: skip
    higher = ColumnParams.model_validate({"levels": 4, "step": "12 mm", "origin": origin})
    assert last.build[1].layout == ("column", higher)


def test_a_scalar_means_the_same_as_its_mapping() -> None:
    short, long = (
        scenario(f"{{scenario: a, build: [{{column: {{levels: 3}}}}], world: {{tilt: {tilt}}}, expect: {expect}}}")
        for tilt, expect in [
            ("5 deg", "[{drift: < 2 mm}, {height: '> 1 mm'}, {stands: all, system: thesis}]"),
            ("{angle: 5 deg}", "[{drift: {is: < 2 mm}}, {height: {is: '> 1 mm'}}, {stands: all, system: [thesis]}]"),
        ]
    )
    assert short == long


def test_stands_all_and_collapses_any_leave_every_key_open() -> None:
    stands, collapses = scenario(
        "{scenario: a, build: [{column: {levels: 3}}], expect: [{stands: all}, {collapses: any}]}"
    ).expect
    assert stands.content == Stands.model_construct()
    assert collapses.content == Collapses.model_construct()


def test_expectations_are_read_with_their_units() -> None:
    expect = [expectation.content for expectation in validated(variants(EVERYTHING)[0]).expect]
    stands, collapses, drift, rests_on = expect[1], expect[3], expect[6], expect[7]
    assert isinstance(stands, Stands)
    assert stands.for_ == 3.0
    assert isinstance(collapses, Collapses)
    assert collapses.at == between(8, 10, "level 9 ± 1")
    assert collapses.time == between(9.0, 11.0, "9 s .. 11 s")
    assert isinstance(drift, Drift)
    assert drift.within == between(0.0005, 0.0015, "1 ± 0.5 mm")
    assert isinstance(rests_on, RestsOn)
    assert rests_on.share == between(0.48, 0.52, "50 % ± 2 %")
    sways, penetrates = expect[11], expect[12]
    assert isinstance(sways, Sways)
    assert sways.frequency == between(1.0, 5.0, "1 Hz .. 5 Hz")
    assert isinstance(penetrates, Penetrates)
    assert penetrates.depth.holds(1e-4)
    assert not penetrates.depth.holds(1.1e-4)


# --- bricks -----------------------------------------------------------------------------------------------------------


def test_a_brick_has_the_mass_of_its_density_or_the_density_of_its_mass() -> None:
    size = ["100 mm", "20 mm", "10 mm"]
    by_density, by_mass = brick({"size": size, "density": "500 kg/m3"}), brick({"size": size, "mass": "10 g"})
    for kind in (by_density, by_mass):
        assert kind.mass_of(kind.form) == pytest.approx(0.010, rel=1e-12)
        assert kind.mass_of(cut_to(kind.form, (0.05, 0.02, 0.01))) == pytest.approx(
            0.005, rel=1e-12
        )  # a half plank weighs half


@pytest.mark.parametrize("name", CATALOGUE)
def test_catalogue_bricks_are_known_by_name(name: str) -> None:
    assert (brick(name).size, brick(name).density) == (CATALOGUE[name].size, CATALOGUE[name].density)


# --- editors ----------------------------------------------------------------------------------------------------------


@cache
def validators() -> tuple[jsonschema.protocols.Validator, jsonschema.protocols.Validator]:
    """Return validators of the published schema and of the internal one."""
    return jsonschema.Draft7Validator(json.loads(schema_text())), jsonschema.Draft202012Validator(json_schema())


def accepted_by_editors(text: str) -> bool:
    """Return whether both schemas accept a scenario; they must agree."""
    (source,) = parse(text, "a.yaml").sources  # as YAML 1.2: PyYAML takes the key `on` for true
    published, ours = (validator.is_valid(source.values) for validator in validators())
    assert published == ours
    return published


def test_a_build_makes_its_files_with_what_it_installs(tmp_path: Path) -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    needed, installed = (
        {re.split("[>=; ]", each)[0].replace("pyyaml", "yaml") for each in requirements}
        for requirements in (settings["project"]["dependencies"], settings["build-system"]["requires"])
    )
    missing = dict.fromkeys(needed - installed)
    (tmp_path / "api").mkdir()
    writing = f"from stackdsl.built_files import *; write_built_files(Path({str(tmp_path)!r}))"
    code = f"import sys; sys.modules |= {missing!r}; {writing}"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)
    assert (tmp_path / "scenario.schema.json").read_text(encoding="utf-8") == schema_text()
    assert {file.name for file in (tmp_path / "api").iterdir()} == {"claims.pyi", "impacts.pyi", "layouts.pyi"}


def test_repeated_parts_of_the_schema_are_in_defs() -> None:
    text = schema_text()
    assert text.count('"write a length with its unit"') == 1
    assert text.count("position [x, y, z] of the origin of the layout") == 1


def test_the_schema_is_a_valid_one() -> None:
    jsonschema.Draft202012Validator.check_schema(json_schema())
    jsonschema.Draft7Validator.check_schema(json.loads(schema_text()))


def test_a_layout_of_the_registry_is_a_key_of_a_step() -> None:
    assert set(LAYOUTS) | {
        "bricks",
        "imported",
        "name",
        "brick",
        "jitter",
        "every",
        "until",
        "place",
        "at",
        "after",
        "repeat",
    } == set(models().BuildStep.model_fields)
    keys = {"import" if key == "imported" else key for key in models().BuildStep.model_fields}
    assert set(keys_at(("build", 0))) == keys | {"include"}
    assert set(keys_at(("build", 0, "wall"))) == {"levels", "bricks", "gap", "origin", "heading", "omit", "mortar"}


def test_editors_show_a_description_of_every_key() -> None:
    def undescribed(schema: dict[str, Any], name: str) -> list[str]:
        inside = [key for part in schema.get("anyOf", ()) for key in undescribed(part, name)]
        named = schema.get("properties", {}).items()
        missing = [f"{name}.{key}" for key, value in named if "description" not in value and "$ref" not in value]
        return inside + missing

    schema = json_schema()
    definitions: dict[str, Any] = schema["$defs"]
    assert undescribed(schema, "Scenario") == []
    assert [key for name, part in definitions.items() for key in undescribed(part, name)] == []


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("where", ["systems: [SYSTEM]", "expect: [{stands: all, system: SYSTEM}]"])
def test_editors_know_the_systems(system: str, where: str) -> None:
    text = f"{{scenario: a, build: [{{column: {{levels: 3}}}}], {where}}}"
    assert accepted_by_editors(text.replace("SYSTEM", system))
    assert not accepted_by_editors(text.replace("SYSTEM", "stok"))


def test_editors_accept_a_scenario_that_uses_everything() -> None:
    assert accepted_by_editors(EVERYTHING)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("scenario: everything", "scenario: Every thing"),
        ("scenario: everything", "{}"),
        ("tags: [example]", "tag: [example]"),
        ("friction: 0.4", "friction: -1"),
        ("friction: 0.4", "friction: '0.4'"),
        ("gravity: 1 g0", "gravity: 9.81"),
        ("distance: 0.5 m", "distance: 0.5 s"),
        ("density: 500 kg/m3", "density: 500 kg"),
        ("density: 500 kg/m3", "density: 500 kg/m3, mass: 1 g"),
        ("brick: kapla-ideal", "brick: kapla ideal"),
        ("name: tower", "column: {levels: 3}"),
        ("levels: 4, step", "levels: four, step"),
        ("levels: 4, step", "levels: 0, step"),
        ("after: built", "after: finished"),
        ("rotate: [0 deg, 0 deg, 90 deg]", "rotate: [0 deg, 90 deg]"),
        ("drop: true", "drop: 1"),
        ("stands: all", "stands: al"),
        ("collapses: any", "collapses: false"),
        ("at: level 9 ± 1", "at: 9 ± 1"),
        ("bricks: <= 2", "bricks: less than 2"),
        ("drift: < 2 mm", "drift: 2 mm"),
        ("source: closed form", "sauce: closed form"),
    ],
)
def test_schema_rejects_mistakes(old: str, new: str) -> None:
    assert EVERYTHING.count(old) >= 1
    wrong = "build: []" if new == "{}" else EVERYTHING.replace(old, new, 1)
    assert not accepted_by_editors(wrong)
    (values,) = [yaml.safe_load(wrong)]
    with pytest.raises(ValidationError):
        models().Scenario.model_validate(values)
