"""What cannot be built, meant, or hold all at once is told in its place, with a remedy."""

import pytest

from stackdsl.compiler import fit
from tests.scenes import mistakes_of


@pytest.mark.parametrize(
    ("build", "rest", "code", "words"),
    [
        ("- bricks: [{at: [0 mm, 0 mm, 3 mm]}]", "", "SD201", "0.9 mm inside ground"),
        ("- bricks: [{at: [0 mm, 0 mm, 3.9 mm]}, {at: [50 mm, 0 mm, 5 mm]}]", "", "SD201", "inside brick 'L1.1'"),
        ("- bricks: [{at: [0 mm, 0 mm, 50 mm]}]", "", "SD202", "46.1 mm away"),
        ("- column: {levels: 3, step: 130 mm}", "", "SD202", "brick 'L2.1' has no support"),
        ("- bricks: [{name: a, at: [0 mm, 0 mm, 3.9 mm]}, {name: a, at: [0 mm, 0 mm, 11.7 mm]}]", "", "SD203", "'a'"),
        ("- column: {levels: 2}", "expect: [{rests_on: {brick: L2.1, support: L1.9}}]", "SD204", "no brick 'L1.9'"),
        ("- column: {levels: 2}", "expect: [{stands: {bricks: [L1.1, roof]}}]", "SD204", "no brick 'roof'"),
        ("- column: {levels: 2}\n  after: level 3", "", "SD205", "no earlier step"),
    ],
)
def test_what_cannot_be_built_or_meant_is_told(build: str, rest: str, code: str, words: str) -> None:
    mistakes = mistakes_of(build, rest)
    assert [mistake.code for mistake in mistakes] == [code]
    assert words in mistakes[0].message
    assert mistakes[0].hint


@pytest.mark.parametrize(
    ("stands", "collapses"),
    [
        ("stands: all", "collapses: any"),
        ("stands: {for: 3 s}", "collapses: {at: level 2, time: 1 s .. 2 s}"),
        ("stands: {levels: 3}", "collapses: any"),
        ("stands: {levels: 2}", "collapses: {brick: L2.1}"),
        ("stands: {bricks: [L3.1]}", "collapses: {brick: L3.1}"),
        ("stands: {bricks: [L3.1, L1.1, L2.1]}", "collapses: any"),
        ("stands: all, system: tuned", "collapses: any, system: [thesis, tuned]"),
    ],
)
def test_expectations_that_cannot_both_hold_are_told_at_the_second(stands: str, collapses: str) -> None:
    for first, second in [(stands, collapses), (collapses, stands)]:
        rest = f"systems: [thesis, tuned]\nexpect:\n  - {{{first}}}\n  - drift: < 1 mm\n  - {{{second}}}"
        (mistake,) = mistakes_of("- column: {levels: 3}", rest)
        assert (mistake.code, str(mistake.span)) == ("SD104", "scene.yaml:8:6")
        kind = first.partition(":")[0]
        assert f"`{kind}` at 6:6 contradict each other on " in mistake.message
        assert mistake.message.endswith("tuned")
        assert "system:" in mistake.hint


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("stands: all, system: thesis", "collapses: any, system: tuned"),
        ("stands: {levels: 2}", "collapses: any"),  # the third level may fall
        ("stands: {levels: 2}", "collapses: {brick: L3.1}"),
        ("stands: {bricks: [L1.1]}", "collapses: {brick: L3.1}"),
        ("stands: {for: 1 s}", "collapses: any"),  # after a second: it is watched for three
        ("stands: all", "drift: < 1 mm"),
    ],
)
def test_expectations_that_can_both_hold_are_let_be(one: str, other: str) -> None:
    watched = "truth: [{stands: {for: 3 s}, source: none}]"
    rest = f"systems: [thesis, tuned]\nexpect:\n  - {{{one}}}\n  - {{{other}}}\n{watched}"
    assert mistakes_of("- column: {levels: 3}", rest) == []


def test_what_is_known_from_outside_may_contradict_what_is_expected() -> None:
    rest = "expect: [{stands: all}]\ntruth: [{collapses: any, source: closed form}]"
    assert mistakes_of("- column: {levels: 3}", rest) == []


def test_a_scenario_that_would_take_hours_to_compile_is_refused_at_once() -> None:
    mistakes = mistakes_of("\n".join(["- wall: {levels: 1, bricks: 15100}"] * 2))
    assert [mistake.code for mistake in mistakes] == ["SD206"]


def test_stones_with_many_edges_count_for_more_than_boxes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fit, "MAX_COST", 1000.0)
    assert mistakes_of("- column: {levels: 100}") == []
    (mistake,) = mistakes_of("- arch: {span: 2 m, thickness: 300 mm, voussoirs: 100}")
    assert (mistake.code, "the search for contacts takes too long" in mistake.message) == ("SD206", True)


def test_a_structure_cannot_be_stable_and_unstable_at_once() -> None:
    found = mistakes_of(
        "- column: {levels: 1}", "systems: [exact]\nexpect:\n  - verdict: stable\n  - verdict: unstable"
    )
    assert [mistake.code for mistake in found] == ["SD104"]
    assert "contradict each other on exact" in found[0].message


def test_a_support_that_is_misspelt_may_be_meant_for_the_ground() -> None:
    found = mistakes_of("- column: {levels: 1}", "expect:\n  - rests_on: {brick: L1.1, support: grund}")
    assert [(mistake.code, mistake.hint) for mistake in found] == [("SD204", "did you mean 'ground'?")]


# --- claims of more than there is -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("claim", "built"),  # of four levels with eight bricks
    [
        ("stands: {levels: 5}", "the claim needs 5 levels, but the structure has 4"),
        ("untouched: {levels: 5}", "the claim needs 5 levels, but the structure has 4"),
        ("leaves: {levels: 5 .. 7}", "the claim needs 5 levels, but the structure has 4"),
        ("leaves: {levels: '> 4'}", "the claim needs 5 levels, but the structure has 4"),
        ("leaves: {bricks: '>= 9'}", "the claim needs 9 bricks, but the structure has 8"),
        ("falls: {count: 9}", "the claim needs 9 bricks, but the structure has 8"),
        ("stands: {levels: 4}", None),
        ("untouched: {levels: 4}", None),
        ("leaves: {levels: 3 .. 7}", None),
        ("leaves: {bricks: '>= 8'}", None),
        ("falls: {count: <= 100}", None),
    ],
)
def test_a_claim_of_more_than_is_built_is_a_mistake(claim: str, built: str | None) -> None:
    for key in (f"expect: [{{{claim}}}]", f"truth: [{{{claim}, source: a book}}]"):
        found = mistakes_of("- four_stack: {levels: 4}", key)
        assert [(mistake.code, mistake.message) for mistake in found] == ([("SD205", built)] if built else [])
