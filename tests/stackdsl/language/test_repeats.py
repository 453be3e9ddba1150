"""`repeat`, ranges, `cases` and `exclude`: expansion, mistakes, and places of mistakes."""

import pytest

from stackdsl.language import variants
from stackdsl.language.expressions import values_of
from stackdsl.language.repeats import MAX_REPEATS, MAX_SPREAD, MAX_VARIANTS
from stackdsl.language.variants import expand
from stackdsl.language.yaml.source import Plain, parse
from stackdsl.timeline import Removal
from tests.scenes import compiled, mistakes_of, timeline_of

JENGA = """
- repeat: {level: 1 .. 18}
  bricks:
    - repeat: {side: -1 .. 1}
      at:
        - ${side * 39.2 mm * sin(90 deg * level)}
        - ${side * 39.2 mm * cos(90 deg * level)}
        - ${(level - 1/2) * 7.8 mm}
      rotate: [0 deg, 0 deg, "${90 deg * level}"]
"""


def named(text: str) -> list[str]:
    """The cases of a scenario, by their names."""
    cases, mistakes = compiled(text)
    assert mistakes == []
    return [case.name for case in cases]


@pytest.mark.parametrize(
    ("written", "values"),
    [
        ("1 .. 4", [1, 2, 3, 4]),
        ("4 .. 1 by -1", [4, 3, 2, 1]),
        ("0.1 .. 0.3 by 0.1", [0.1, 0.2, 0.3]),
        ("5 mm .. 6 mm by 0.5 mm", ["5 mm", "5.5 mm", "6 mm"]),
        ("9 mm .. 1.1 cm by 1 mm", ["9 mm", "10 mm", "11 mm"]),
        ("0 deg .. 90 deg by 45 deg", ["0 deg", "45 deg", "90 deg"]),
        ("7 .. 7", [7]),
        (["kapla", 3, "2 mm"], ["kapla", 3, "2 mm"]),
    ],
)
def test_a_range_has_the_values_that_its_steps_meet(written: Plain, values: list[object]) -> None:
    assert values_of(written, 9) == values


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ("5 mm .. 15 mm", "no step"),
        ("1 .. 4 by 2", "end at 3"),
        ("4 .. 1", "does not lead to its last value"),
        ("1 .. 4 by 0", "does not lead to its last value"),
        ("1 mm .. 4 s by 1 mm", "different units"),
        ("1 .. x", "cannot be read at 'x'"),
        ("0 .. 1000000000", "has 1000000001 values; the maximum is 9"),
        ("0 mm .. 1 km by 0.000001 mm", "has 1000000000001 values"),
    ],
)
def test_invalid_range_is_rejected_before_its_values_are_made(written: str, words: str) -> None:
    (mistake,) = compiled(f"scenario: a\nmatrix: {{n: {written}}}\nbuild: [{{column: {{levels: '${{n}}'}}}}]")[1]
    assert (mistake.span.line, mistake.span.column) == (2, 13)
    assert words.replace("maximum is 9", f"maximum is {MAX_VARIANTS}") in mistake.message
    assert mistake.hint


def test_jenga_tower_of_54_bricks_is_one_repeated_brick() -> None:
    bricks = timeline_of(JENGA).placements
    assert [placement.brick.id for placement in bricks] == [
        f"L{level}.{n}" for level in range(1, 19) for n in (1, 2, 3)
    ]
    assert bricks[-1].pose.position_W[2] == pytest.approx(17.5 * 0.0078)
    assert bricks[0].pose.position_W == (-0.0392, 0.0, 0.0039)  # sines of right angles are exact, of many turns too


def test_repeated_impacts_follow_each_other_by_every() -> None:
    impacts = """
    impacts:
      - repeat: {level: 17 .. 1 by -2, n: [2, 1]}
        after: built + 3 s
        every: 500 ms
        remove: {brick: "L${level}.${n}"}
      - {after: impact 18 + 1 s, remove: {brick: L18.1}}
    """
    pulled = [action for action in timeline_of(JENGA, impacts).actions if isinstance(action, Removal)]
    expected = [f"L{level}.{n}" for level in range(17, 0, -2) for n in (2, 1)] + ["L18.1"]
    assert [action.bricks for action in pulled] == [(name,) for name in expected]
    assert [action.time for action in pulled] == pytest.approx([3 + 0.5 * n for n in range(18)] + [3 + 8.5 + 1])


def test_steps_and_claims_are_repeated_and_ranges_may_depend_on_outer_variables() -> None:
    cases, mistakes = compiled("""
        scenario: stairs
        let: {count: 3}
        build:
          - repeat: {x: "1 .. ${count}"}
            column: {levels: "${x}", origin: ["${x * 200 mm}", 0 mm, 0 mm]}
            name: c${x}
            every: 1 s
          - bricks: [{name: mark, at: [2 m, 0 m, 3.9 mm]}]
        expect:
          - repeat: {x: "1 .. ${count}", level: "1 .. ${x}"}
            height: {of: "c${x}.L${level}.1", is: "${level * 7.8 mm} ± 1 mm"}
    """)
    assert [mistake.message for mistake in mistakes] == ["unknown variable 'x'"]  # of one repeat none knows another
    cases, mistakes = compiled("""
        scenario: stairs
        build:
          - repeat: {x: 1 .. 3}
            bricks:
              - repeat: {level: "1 .. ${x}"}
                at: ["${x * 200 mm}", 0 mm, "${(level - 1/2) * 7.8 mm}"]
            every: 1 s
        expect:
          - {repeat: {n: 1 .. 3}, height: {of: "L1.${n}", is: 7.8 mm ± 1 mm}}
    """)
    assert mistakes == []
    assert [placed.time for placed in cases[0].timeline.placements] == [0, 1, 2, 3, 4, 5]
    assert len(cases[0].scenario.expect) == 3


def test_mistake_in_a_repetition_is_reported_once_with_the_repetition() -> None:
    bricks = "- bricks: [{repeat: {n: 0 .. 999}, at: [0 m, 0 m, 3.9 mm], nmae: 'b${n}'}]"
    (mistake,) = mistakes_of(bricks)
    assert (str(mistake.span), mistake.span.where, mistake.message) == (
        "scene.yaml:3:62",
        "n = 0",
        "unknown key 'nmae'",
    )
    (mistake,) = mistakes_of("- repeat: {x: 1 .. 9}\n  column: {levels: '${x - 3}', origin: ['${x * 1 m}', 0 m, 0 m]}")
    assert (mistake.span.where, mistake.message) == ("x = 1", "-2 is below the minimum of 1")


def test_items_after_a_repetition_keep_their_places() -> None:
    (mistake,) = mistakes_of(JENGA + "- column: {levels: 3, origin: [1 m, 0 m, 5 mm]}")
    assert (mistake.code, mistake.span.line, mistake.span.where) == ("SD202", 11, "")


def test_duplicate_name_in_repetitions_reports_the_repetition() -> None:
    mistake, *_ = mistakes_of("- bricks: [{repeat: {x: 0 .. 1}, name: a, at: ['${x * 1 m}', 0 m, 3.9 mm]}]")
    assert "'a'; the other one is at 3:14 (x = 0)" in mistake.message
    assert mistake.span.where == "x = 1"


@pytest.mark.parametrize(
    ("loops", "words"),
    [
        ("{i: 1 .. 1000000000}", f"has 1000000000 values; the maximum is {MAX_REPEATS}"),
        ("{i: 1 .. 1000, j: 1 .. 1000, k: 1 .. 1000}", "yields more than the maximum"),
        ("{" + ", ".join(f"v{n}: 1 .. 10" for n in range(5000)) + "}", "yields more than the maximum"),  # 10^5000
        ("{i: '1 .. ${n}'}", "unknown variable 'n'"),
        ("{mm: 1 .. 2}", "is a unit"),
        ("3", "expected variables and their values, not 3"),
        ("{}", "expected variables and their values"),
    ],
)
def test_invalid_repeat_is_rejected(loops: str, words: str) -> None:
    text = f"- bricks:\n    - {{repeat: {loops}, at: [0 m, 0 m, 3.9 mm]}}"
    mistake = mistakes_of(text)[0]
    assert words in mistake.message
    assert mistake.span.line == 4


def nest(depth: int, turns: int) -> str:
    """Steps that repeat bricks that are repeated."""
    loops = ", ".join(f"v{n}: 1 .. {turns}" for n in range(depth))
    return f"- repeat: {{{loops}}}\n  bricks:\n    - repeat: {{w: 1 .. 20000}}\n      at: [0 m, 0 m, 3.9 mm]"


def test_nested_repeats_are_limited_together() -> None:
    (mistake,) = mistakes_of(nest(2, 100))
    assert mistake.code == "SD206"
    assert f"more than {MAX_SPREAD} values" in mistake.message


def test_expressions_in_repeats_count_towards_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(variants, "MAX_EXPRESSIONS", 200)
    (mistake,) = mistakes_of("- bricks:\n    - {repeat: {i: 1 .. 200}, name: 'b${i}', at: ['${i * 1 m}', 0 m, 3.9 mm]}")
    assert (mistake.code, "more than 200 expressions" in mistake.message) == ("SD206", True)


def test_equal_mistakes_in_all_repetitions_are_reported_once() -> None:
    (mistake,) = mistakes_of("- bricks: [{repeat: {i: 3 .. 200}, name: 'b${i}', at: ['${i * 1 m}', 0 m, 5 mm]}]")
    assert (mistake.code, mistake.span.where, "'b3'" in mistake.message) == ("SD202", "i = 3", True)


def test_every_needs_repeat() -> None:
    (mistake,) = mistakes_of("- column: {levels: 2}", "impacts: [{every: 1 s, remove: {brick: L2.1}}]")
    assert (mistake.code, mistake.span.column) == ("SD102", 12)
    loop = "impacts: [{repeat: {n: [2, 1]}, every: 1, remove: {brick: 'L${n}.1'}}]"
    (mistake,) = mistakes_of("- column: {levels: 2}", loop)
    assert (mistake.code, mistake.span.column) == ("SD105", 40)


# --- cases and exclude ------------------------------------------------------------------------------------------------

CASES = """
scenario: shot
cases:
  - {speed: 1 m/s, shift: 34 mm}
  - {speed: 2.5 m/s, shift: 99 mm}
build: [{column: {levels: 2}}]
expect: [{drift: "< ${shift + speed * 1 ms}"}]
"""


def test_cases_are_named_by_their_first_value() -> None:
    assert named(CASES) == ["shot[speed=1m/s,exact]", "shot[speed=2.5m/s,exact]"]
    variants, _ = expand(parse(CASES, "a.yaml").sources[0])
    assert [variant.values["expect"] for variant in variants] == [[{"drift": "< 35 mm"}], [{"drift": "< 101.5 mm"}]]


def test_cases_are_combined_with_the_matrix_and_exclude() -> None:
    text = CASES.replace("build:", "matrix: {levels: 2 .. 3}\nexclude: [{levels: 3, speed: 2500 mm/s}]\nbuild:")
    text = text.replace("levels: 2}", "levels: '${levels}'}")
    assert named(text.replace("2500 mm/s", "2.5 m/s")) == [
        "shot[speed=1m/s,levels=2,exact]",
        "shot[speed=1m/s,levels=3,exact]",
        "shot[speed=2.5m/s,levels=2,exact]",
    ]


def test_words_and_brick_names_are_values() -> None:
    text = "scenario: a\nmatrix: {brick: [kapla, kapla-ideal]}\nlet: {top: L2.1}\nbrick: ${brick}\n"
    text += "build: [{column: {levels: 2}}]\nexpect: [{stands: {bricks: ['${top}']}}]"
    assert named(text) == ["a[brick=kapla,exact]", "a[brick=kapla-ideal,exact]"]


@pytest.mark.parametrize(
    ("cases", "code", "words"),
    [
        ("[]", "SD103", "expected a list of mappings"),
        ("{a: 1}", "SD103", "expected a list of mappings"),
        ("[{a: 1}, {b: 1}]", "SD102", "this case has no value for 'a'"),
        ("[{a: 1, b: 2}, {a: 2, b: 1, c: 3}]", "SD101", "unknown variable 'c'"),
        ("[{a: 1, b: 2}, {a: 1, b: 1}]", "SD104", "two cases have the same first value"),
        ("[{a: 1 x}]", "SD109", "'1 x' is neither"),
        ("[{m: 1}]", "SD109", "is a unit"),
    ],
)
def test_inconsistent_cases_are_rejected(cases: str, code: str, words: str) -> None:
    found = expand(parse(f"{{scenario: a, cases: {cases}, friction: '${{a + b}}'}}", "a.yaml").sources[0])[1]
    assert (code, True) in {(each.code, words in each.message) for each in found}


@pytest.mark.parametrize(
    ("exclude", "code", "words"),
    [
        ("[{a: 3}]", "SD104", "no combination has these values"),
        ("[{c: 1}]", "SD109", "unknown variable 'c'"),
        ("[{a: 1}, {a: 2}]", "SD104", "removes all combinations"),
        ("{a: 1}", "SD103", "expected a list of mappings"),
    ],
)
def test_excluded_combination_must_exist(exclude: str, code: str, words: str) -> None:
    text = f"{{scenario: a, matrix: {{a: [1, 2]}}, exclude: {exclude}, friction: '${{a}}'}}"
    (mistake,) = expand(parse(text, "a.yaml").sources[0])[1]
    assert (mistake.code, words in mistake.message) == (code, True)


def test_brick_types_are_valid_wherever_a_brick_is_expected() -> None:
    cases, mistakes = compiled("""
        scenario: types
        brick_types:
          carton: {size: [300 mm, 200 mm, 100 mm], mass: 5 kg}
          slat: {size: [300 mm, 200 mm, 20 mm], mass: 1 kg}
        matrix: {kind: [carton, slat]}
        brick: ${kind}
        build:
          - column: {levels: 2}
          - {column: {levels: 1, origin: [1 m, 0, 0]}, brick: slat, name: b}
          - bricks: [{name: c, at: [2 m, 0, 50 mm], brick: carton}]
        impacts:
          - insert: {name: d, at: [3 m, 0, 10 mm], brick: slat}
          - drop: {onto: c, height: 1 mm, brick: carton, name: e}
          - throw: {at: b.L1.1, from: {bearing: 0 deg}, speed: 1 m/s, brick: slat, name: f}
    """)
    assert mistakes == []
    masses = {placed.brick.id: placed.brick.mass for placed in cases[0].timeline.placements}
    assert masses == {"L1.1": 5, "L2.1": 5, "b.L1.1": 1, "c": 5, "d": 1, "e": 5, "f": 1}
    assert cases[1].timeline.placements[0].brick.mass == 1
