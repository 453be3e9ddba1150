"""What a scenario says of friction by kind, by brick and by pair, and how it is told what is mistaken in it."""

import pytest

from stability.contact_law import Friction, as_friction
from stackdsl.diagnostics import Diagnostic
from stackdsl.timeline import Timeline
from tests.scenes import compiled

HEAD = """
scenario: scene
brick_types:
  sheet: {size: [200 mm, 100 mm, 2 mm], density: 900 kg/m3, friction: 0.1}
  carton: {size: [100 mm, 80 mm, 60 mm], density: 300 kg/m3}
brick: carton
friction: 0.5
"""
BUILD = """
build:
  - bricks:
      - {name: base, brick: sheet, on: ground}
      - {name: low, on: base}
      - {name: high, on: low, friction: 0.3}
"""


def timeline(world: str, rest: str = "") -> Timeline:
    """Of a sheet and two cartons, in this world."""
    cases, mistakes = compiled(f"{HEAD}world: {world}\n{BUILD}{rest}")
    assert mistakes == []
    return cases[0].timeline


def mistakes(pairs: str, build: str = BUILD) -> list[Diagnostic]:
    """What is told of these pairs, which stand in line 8."""
    return compiled(f"{HEAD}world: {{friction: {{between: [{pairs}]}}}}\n{build}")[1]


def test_a_scenario_without_other_frictions_has_one_number() -> None:
    assert compiled("scenario: s\nfriction: 0.4\nbuild: [{column: {levels: 2}}]\n")[0][0].timeline.world.friction == 0.4


def test_a_brick_has_the_friction_of_its_kind_unless_it_is_given_another() -> None:
    world = timeline("{ground: {friction: 0.6}}").world
    law = as_friction(world.friction)
    assert [law.of("base", "low"), law.of("low", "high")] == [0.1, 0.3]
    assert [law.on("base", world.planes[0]), law.on("low", world.planes[0])] == [0.1, 0.6]


def test_a_pair_may_be_of_kinds_of_bricks_and_of_what_is_fixed() -> None:
    pairs = "[{pair: [sheet, carton], friction: 0.2}, {pair: [ground, base], friction: 0.7}]"
    world = timeline(f"{{friction: {{between: {pairs}}}}}").world
    law = as_friction(world.friction)
    assert [law.of("base", "high"), law.on("base", world.planes[0])] == [0.2, 0.7]


def test_the_rule_of_two_is_written() -> None:
    law = as_friction(timeline("{friction: {rule: mean}}").world.friction)
    assert law.of("base", "low") == pytest.approx(0.3)


def test_bricks_of_layouts_and_those_that_fly_rub_as_their_kind_does() -> None:
    text = f"{HEAD}{BUILD}  - {{column: {{levels: 2, origin: [1 m, 0 m, 0 m]}}, brick: sheet, name: side}}\n"
    cases, told = compiled(f"{text}impacts: [{{drop: {{onto: high, height: 10 mm, brick: sheet, name: hail}}}}]\n")
    assert told == []
    law = as_friction(cases[0].timeline.world.friction)
    assert [law.of("side.L1.1", "low"), law.of("hail", "low")] == [0.1, 0.1]


def test_a_name_that_a_brick_and_a_kind_share_is_that_of_the_brick() -> None:
    build = "\nbuild:\n  - bricks:\n      - {name: sheet, on: ground}\n      - {name: foil, brick: sheet, on: sheet}\n"
    cases, told = compiled(HEAD + build)
    assert told == []
    law = as_friction(cases[0].timeline.world.friction)
    assert law == Friction(0.5, own={"foil": 0.1})


def test_frictions_may_vary_and_be_uncertain() -> None:
    text = HEAD.replace("friction: 0.1}", "friction: '${mu}'}")
    world = "world: {friction: {between: [{pair: [carton, carton], friction: '${2 * mu}'}]}}"
    cases, told = compiled(f"{text}matrix: {{mu: [0, 0.2]}}\n{world}\n{BUILD}")
    assert told == []
    laws = [as_friction(case.timeline.world.friction) for case in cases]
    assert [(law.of("base", "low"), law.of("low", "high")) for law in laws] == [(0.0, 0.0), (0.2, 0.4)]


@pytest.mark.parametrize(
    ("pairs", "code", "words", "hint"),
    [
        ("{pair: [shet, carton], friction: 0.1}", "SD204", "no brick or kind of brick 'shet'", "sheet"),
        ("{pair: [sheet, wall1], friction: 0.1}", "SD204", "no brick or kind of brick 'wall1'", ""),
        ("{pair: [low, low], friction: 0.1}", "SD104", "'low' is a single brick", "two different bodies"),
        ("{pair: [ground, ground], friction: 0.1}", "SD104", "both bodies are fixed", "at least one brick"),
        (
            "{pair: [sheet, low], friction: 0.1}, {pair: [low, sheet], friction: 0.2}",
            "SD104",
            "already has a friction coefficient of 0.1",
            "keep one",
        ),
        (
            "{pair: [base, carton], friction: 0.1}, {pair: [low, sheet], friction: 0.2}",
            "SD104",
            "different friction coefficients for base and low",
            "[base, low]",
        ),
        ("{pair: [sheet, low], friction: -0.1}", "SD104", "below the minimum of 0", ""),
        ("{pair: [sheet, low], friction: 11}", "SD104", "10", ""),
        ("{pair: [sheet, low], friction: .inf}", "SD009", "", ""),
        ("{pair: [sheet], friction: 0.1}", "SD103", "", ""),
        ("{pair: [sheet, low]}", "SD102", "friction", ""),
    ],
)
def test_what_is_mistaken_in_a_pair_is_told_where_it_stands(pairs: str, code: str, words: str, hint: str) -> None:
    (mistake,) = mistakes(pairs)
    assert (mistake.code, mistake.span.line) == (code, 8)
    assert words in mistake.message
    assert hint in mistake.hint


def test_another_rule_than_those_that_there_are_is_told_with_them() -> None:
    (mistake,) = compiled(f"{HEAD}world: {{friction: {{rule: product}}}}\n{BUILD}")[1]
    assert (mistake.code, mistake.span.line) == ("SD104", 8)
    assert "'product'" in mistake.message
    assert "geometric" in mistake.hint


def test_the_same_may_be_said_of_a_pair_twice_and_one_pair_of_two_names_settles_two_of_kinds() -> None:
    assert mistakes("{pair: [sheet, low], friction: 0.1}, {pair: [low, sheet], friction: 0.1}") == []
    crossing = "{pair: [base, carton], friction: 0.1}, {pair: [low, sheet], friction: 0.2}"
    assert mistakes(f"{crossing}, {{pair: [low, base], friction: 0.3}}") == []


def test_a_kind_in_a_pair_that_is_also_a_brick_is_refused() -> None:
    build = "\nbuild: [{bricks: [{name: sheet, on: ground}]}]\n"
    (mistake,) = mistakes("{pair: [sheet, ground], friction: 0.1}", build)
    assert mistake.code == "SD203"
