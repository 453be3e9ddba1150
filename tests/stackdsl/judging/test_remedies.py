"""Remedies of a fall, against closed forms; the scenario stands with each of them."""

from math import cos, inf, radians, sin, tan

import pytest

from stability.problem import Stability
from stackdsl.judging.numbers import ScenarioNumbers
from stackdsl.judging.proofs import proofs_of
from stackdsl.judging.remedies import Remedies, remedies_of
from tests.scenes import compiled, scene

LENGTH = 117.6  # of a KAPLA plank [mm]


def remedies(build: str, rest: str = "", which: int = 0) -> Remedies:
    cases, mistakes = compiled(scene(build, rest))
    assert mistakes == []
    case = cases[which]
    proofs = proofs_of(case.timeline)
    assert proofs.assembly.verdict().stability is Stability.UNSTABLE
    return remedies_of(ScenarioNumbers(case.scenario, case.variant), case.timeline, proofs)


def limits(found: Remedies) -> dict[tuple[str, bool], float]:
    return {(each.number.name, each.limit.least): each.limit.value for each in found.numbers}


@pytest.mark.parametrize("levels", [5, 8, 10, 12])
def test_a_column_stands_up_to_its_length_over_its_planks(levels: int) -> None:
    found = limits(remedies(f"- column: {{levels: {levels}, step: 30 mm}}\n  every: 1 s"))
    assert found["step", False] == pytest.approx(LENGTH / levels, rel=1e-4)
    assert found["step", False] <= LENGTH / levels * (1.0 + 1e-9)
    assert found["levels", False] == LENGTH // 30.0


def test_a_variable_is_told_before_what_it_is_used_for() -> None:
    found = remedies('- column: {levels: 10, step: "${d}"}', "let: {d: 1.3 cm}")
    first = found.numbers[0]
    assert (first.number.name, first.number.unit, first.limit.value) == ("d", "cm", 1.176)
    assert "step" not in [each.number.name for each in found.numbers]


def test_a_choice_of_the_matrix_is_a_number_too() -> None:
    build, rest = '- column: {levels: "${n}", step: "${d}"}', "matrix: {d: [10 mm, 12 mm], n: [9, 10]}"
    found = limits(remedies(build, rest, which=3))
    assert (found["d", False], found["n", False]) == (11.76, 9.0)


def test_a_value_of_a_case_is_a_number_too() -> None:
    rest = "cases: [{kind: near, d: 10 mm}, {kind: far, d: 12 mm}]\ndescription: how ${kind} it leans"
    found = remedies('- column: {levels: 10, step: "${d}"}', rest, which=1)
    assert limits(found)["d", False] == 11.76


def test_a_number_of_what_is_repeated_is_changed_in_all_repetitions() -> None:
    #   Each plank reaches out by d from the one below; n of them stand up to a step of a length over n.
    build = """
- repeat: {i: 0 .. 4}
  every: 1 s
  bricks: [{name: "p${i}", at: ["${i * d}", 0 mm, "${3.9 mm + i * 7.8 mm}"]}]
"""
    assert limits(remedies(build, "let: {d: 30 mm}"))["d", False] == pytest.approx(LENGTH / 5.0, rel=1e-4)


@pytest.mark.parametrize("friction", [0.2, 0.35])
def test_an_incline_needs_the_tangent_of_its_angle(friction: float) -> None:
    found = remedies("- column: {levels: 1}", f"friction: {friction}\nworld: {{tilt: 20 deg}}")
    assert found.friction is not None
    assert tan(radians(20.0)) <= found.friction.coefficient <= tan(radians(20.0)) + 0.001
    #   ... or a slope of no more than the angle of friction.
    assert tan(radians(limits(found)["tilt", False])) == pytest.approx(friction, rel=1e-3)


def test_a_ladder_at_a_smooth_wall_needs_half_the_cotangent() -> None:
    #   A thin ladder of 60 deg: friction of 1 / (2 tan 60 deg) at its foot.
    wall = "friction: 0.2\nworld: {walls: [{bearing: 0 deg, distance: 0 mm, friction: 0}]}"
    brick = "brick: {size: [1 m, 20 mm, 0.1 mm], density: 500 kg/m3}"
    length, angle = 1.0, radians(60.0)
    x, z = -0.5 * length * cos(angle) - 0.00005 * sin(angle), 0.5 * length * sin(angle) + 0.00005 * cos(angle)
    build = f"- bricks: [{{at: [{1000 * x} mm, 0 mm, {1000 * z} mm], rotate: [0 deg, -60 deg, 0 deg]}}]"
    found = remedies(build, f"{wall}\n{brick}")
    assert found.friction is not None
    assert found.friction.factor * 0.2 == pytest.approx(0.5 / tan(angle), abs=0.001)
    assert not found.friction.alike


def test_no_friction_holds_what_tips() -> None:
    found = remedies("- column: {levels: 3, step: 45 mm}").friction
    assert found is not None
    assert found.factor == inf


def test_the_least_counterweight_follows_from_the_lever() -> None:
    #   A plank 10 mm too far out, and one on its inner end, 40 mm inside the edge: a quarter of a plank in all.
    build = """
- column: {levels: 1}
- bricks:
    - {name: arm, at: [68.8 mm, 0 mm, 11.7 mm]}
    - {name: crumb, at: [18.8 mm, 0 mm, 16.6 mm], brick: {size: [10 mm, 10 mm, 2 mm], mass: 1 g}}
"""
    found = remedies(build).counterweight
    (case, *_), _ = compiled(scene(build))
    arm = next(p.brick.mass for p in case.timeline.placements if p.brick.id == "arm")
    assert found is not None
    assert found.brick == "crumb"
    assert found.mass == pytest.approx(arm * 10.0 / 40.0 - 0.001, rel=0.01)
    assert found.mass >= arm * 10.0 / 40.0 - 0.001
    assert found.next_to_fall == ()


def test_where_nothing_rises_no_counterweight_helps() -> None:
    found = remedies("- column: {levels: 2, step: 70 mm}")
    assert (found.counterweight, found.nothing_rises) == (None, True)
    assert not remedies("- column: {levels: 10, step: 12 mm}").nothing_rises


def test_a_remedy_says_what_still_falls_after_a_counterweight() -> None:
    found = remedies("- column: {levels: 12, step: 12 mm}\n  every: 1 s").counterweight
    assert found is not None
    assert found.brick == "L2.1"
    assert "L11.1" in found.next_to_fall


def test_a_brick_that_moves_may_be_laid_nearer() -> None:
    build = "- column: {levels: 1}\n- name: balcony\n  bricks: [{name: arm, at: [70 mm, 0 mm, 11.7 mm]}]"
    assert limits(remedies(build))["x of balcony.arm", False] == pytest.approx(LENGTH / 2.0, rel=1e-4)


def test_times_and_what_is_worked_out_are_no_numbers_to_change() -> None:
    build = '- column: {levels: 3, step: "${2 * half}"}\n  every: "${pause}"'
    (case,), _ = compiled(scene(build, "let: {pause: 2 s, half: 22 mm}"))
    assert [number.name for number in ScenarioNumbers(case.scenario, case.variant).numbers(())] == ["half", "levels"]


def test_the_structure_stands_with_each_remedy_written_into_its_file() -> None:
    build, rest = "- column: {levels: 7, step: 20 mm}\n  every: 1 s", "friction: 0.5"
    for each in remedies(build, rest).numbers:
        mended = build.replace(
            f"{each.number.name}: {each.number.text(each.number.number)}",
            f"{each.number.name}: {each.number.text(each.limit.value)}",
        )
        assert mended != build
        (case,), mistakes = compiled(scene(mended, rest))
        assert mistakes == []
        assert proofs_of(case.timeline).assembly.verdict().stability is Stability.STABLE
