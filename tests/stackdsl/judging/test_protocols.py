"""Protocols of transport: proven by statics against closed forms, and pulses against a sliding block."""

from dataclasses import replace
from math import atan, degrees, inf

import pytest

from stackdsl.checking.play_case import play_case
from stackdsl.language.claims.claim_result import ClaimResult
from stackdsl.trace import PulseMotion, Trace
from tests.scenes import compiled, mistakes_of, scene

GRAVITY = 9.81


def judged(protocol: str, size: str, friction: float = 2.0) -> tuple[ClaimResult, Trace]:
    """The result of a protocol for one box, and the trace."""
    build = f"- bricks: [{{name: box, on: ground, brick: {{size: {size}, mass: 20 kg}}}}]"
    (case,), mistakes = compiled(scene(build, f"friction: {friction}\nexpect: [protocol: {protocol}]"))
    assert mistakes == []
    trace = play_case(case.timeline, "exact")
    return case.scenario.expect[0].content.judge(trace), trace


FLAT = "[400 mm, 400 mm, 100 mm]"


@pytest.mark.parametrize(("friction", "passes"), [(0.799, False), (0.801, True)])
def test_a_flat_box_bears_0_8_g_forwards_by_so_much_friction(friction: float, passes: bool) -> None:
    result, trace = judged("en-12195-1", FLAT, friction)
    assert result.passed is passes
    assert result.margin == pytest.approx(min(friction - 0.8, friction - 0.5), abs=1e-6)
    assert "forwards 0.8 g proven" in result.measured or "forwards 0.8 g is not borne: up to 0.799 g" in result.measured
    assert trace.cost.steps == 0


@pytest.mark.parametrize(
    ("forward", "size", "passes"),
    [
        ("0 deg", "[820 mm, 520 mm, 1000 mm]", True),
        ("90 deg", "[520 mm, 820 mm, 1000 mm]", True),
        ("0 deg", "[790 mm, 520 mm, 1000 mm]", False),
        ("0 deg", "[820 mm, 490 mm, 1000 mm]", False),
        ("90 deg", "[820 mm, 520 mm, 1000 mm]", False),
    ],
)
def test_a_tall_box_tips_over_its_edge_at_its_width_by_its_height(forward: str, size: str, passes: bool) -> None:
    result, _ = judged(f"{{name: en-12195-1, forward: {forward}}}", size)
    assert result.passed is passes


@pytest.mark.parametrize(("share", "passes"), [(0.999, True), (1.001, False)])
@pytest.mark.parametrize("friction", [0.3, 0.9])
def test_a_tilting_table_slides_a_box_at_the_angle_of_its_friction(friction: float, share: float, passes: bool) -> None:
    angle = share * degrees(atan(friction))
    result, _ = judged(f"{{name: tilting-table, angle: {angle} deg}}", FLAT, friction)
    assert result.passed is passes


def slid(friction: float, most: float = 0.5, step: float = 1e-6) -> float:
    """Return the slide of a block under the pulse of EUMOS 40509: up in 50 ms, held for 0.3 s, down in 50 ms [m]."""
    time = speed = way = 0.0
    while time < 0.4 or speed > 0.0:
        ground = most * min(1.0, time / 0.05, max(0.0, (0.4 - time) / 0.05))
        speed = max(0.0, speed + (ground - friction) * GRAVITY * step)
        way, time = way + speed * step, time + step
    return way


@pytest.mark.parametrize(("friction", "passes"), [(0.51, True), (0.44, True), (0.42, False)])
def test_a_pulse_that_is_not_proven_slides_a_box_as_far_as_coulomb_has_it(friction: float, passes: bool) -> None:
    #   In the lowest 200 mm, 40 mm are allowed; of 1 m of height, 50 mm for good.
    result, trace = judged("eumos-40509", "[800 mm, 800 mm, 1000 mm]", friction)
    assert trace.tests is not None
    for test in trace.tests:
        assert (test.motion is None) is (friction > 0.5)
        if test.motion is not None:
            assert test.motion.permanent == pytest.approx(slid(friction), rel=0.03)
            assert test.motion.height == pytest.approx(1.0)
    assert result.passed is passes
    if friction < 0.5:
        assert result.margin == pytest.approx(1000.0 * (0.04 - slid(friction)), abs=2.0)


def test_another_level_of_the_pulse_is_judged() -> None:
    assert judged("{name: eumos-40509, acceleration: 0.3 g}", FLAT, 0.31)[0].passed
    assert not judged("{name: eumos-40509, acceleration: 0.8 g}", FLAT, 0.31)[0].passed


def test_a_box_that_a_pulse_tips_over_fails() -> None:
    result, _ = judged("{name: eumos-40509, acceleration: 0.8 g}", "[100 mm, 100 mm, 1000 mm]")
    assert not result.passed
    assert "1 bricks fall" in result.measured


@pytest.mark.parametrize(
    ("changes", "passes"),
    [
        ({}, True),
        ({"largest": 0.101}, False),
        ({"permanent": 0.051}, False),
        ({"lowest": 0.041}, False),
        ({"fallen": ("box",)}, False),
        ({"is_moving": True}, False),
        ({"largest": 0.099, "permanent": 0.049, "lowest": 0.039}, True),
    ],
)
def test_a_pulse_passes_within_all_limits_of_its_standard(changes: dict[str, object], passes: bool) -> None:
    _, trace = judged("eumos-40509", FLAT, 0.6)
    assert trace.tests is not None
    still = PulseMotion(1.0, 0.0, 0.0, 0.0, (), is_moving=False)
    moved = replace(still, **changes)  # type: ignore[arg-type]
    tests = tuple(replace(test, survived=0.4, motion=moved) for test in trace.tests)
    (case,), _ = compiled(scene("- column: {levels: 1}", "expect: [protocol: eumos-40509]"))
    assert case.scenario.expect[0].content.judge(replace(trace, tests=tests)).passed is passes


def test_a_structure_that_does_not_stand_is_not_tested() -> None:
    build = "- bricks: [{name: low, on: ground}, {name: top, at: [60 mm, 0 mm, 11.7 mm]}]"
    (case,), _ = compiled(scene(build, "expect: [protocol: en-12195-1]"))
    result = case.scenario.expect[0].content.judge(play_case(case.timeline, "exact"))
    assert not result.passed
    assert result.margin == -inf
    assert "no test" in result.measured


@pytest.mark.parametrize(
    ("rest", "code", "words"),
    [
        ("expect: [protocol: en-12195]", "SD104", "en-12195"),
        ("expect: [protocol: tilting-table]", "SD102", "the tilt of `tilting-table`, is missing"),
        ("expect: [protocol: {name: en-12195-1, angle: 3 deg}]", "SD108", "`angle` does not apply"),
        (
            "expect: [protocol: {name: tilting-table, angle: 3 deg, acceleration: 0.5 g}]",
            "SD108",
            "`acceleration` does not",
        ),
        ("expect: [protocol: {name: tilting-table, angle: 89 deg}]", "SD104", "out of range"),
        ("world: {tilt: 3 deg}\nexpect: [protocol: en-12195-1]", "SD104", "the scenario has a `tilt`"),
        (
            "world: {shake: {pulse: triangle, acceleration: 1 m/s2, for: 1 s}}\nexpect: [protocol: en-12195-1]",
            "SD104",
            "the scenario has a `shake`",
        ),
        (
            "loads: [{brick: L1.1, weight: 1 kg}]\nexpect: [protocol: {name: tilting-table, angle: 3 deg}]",
            "SD211",
            "the tilt that loaded bricks bear",
        ),
        ("systems: [tuned]\nexpect: [protocol: en-12195-1]", "SD104", "needs proofs of statics"),
    ],
)
def test_impossible_protocols_have_a_diagnostic(rest: str, code: str, words: str) -> None:
    (mistake,) = mistakes_of("- column: {levels: 2}", rest)
    assert mistake.code == code
    assert words in mistake.message
    assert mistake.hint
