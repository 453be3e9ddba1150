"""Wind, liquids, soil and accelerations as loads, against closed forms: each limit is proven to a millionth."""

from math import cos, pi, radians, sin, tan

import pytest

from stability import Stability
from tests.scenes import mistakes_of
from tests.stackdsl.loads.test_closed_forms import ACCURACY, BLOCK, MU, ON_THE_GROUND, B, D, H, W, factor_of, verdict_of

WALL = "\nbrick: {{size: [{b} m, 1 m, {h} m], density: 2000 kg/m3}}\nfriction: {mu}"


def wall(base: float, height: float, friction: float, blocks: int = 1) -> tuple[str, str]:
    """Return the build of a wall of blocks on each other, 1 m long, and its scene."""
    each = height / blocks
    bricks = [f"{{name: b{i}, at: [0 m, 0 m, {(i + 0.5) * each} m]}}" for i in range(blocks)]
    return f"- bricks: [{', '.join(bricks)}]", WALL.format(b=base, h=each, mu=friction)


@pytest.mark.parametrize(
    ("base", "friction", "surface", "blocks"), [(0.6, 0.8, 2.0, 3), (1.6, 0.3, 1.3, 1), (0.6, 0.8, 2.6, 1)]
)
def test_a_retaining_wall_slides_or_overturns_at_the_closed_form(
    base: float, friction: float, surface: float, blocks: int
) -> None:
    #      |~~~~ surface at z = s     The thrust per length is gamma s^2 / 2 at s / 3 above the toe. Above the top of
    #   |--|~~~                       the wall there is no face, so a surface at s > h leaves a trapezium.
    height, gamma = 2.0, 6000.0
    build, scene = wall(base, height, friction, blocks)
    weight = 2000.0 * 9.81 * base * height
    dry = max(surface - height, 0.0)  # depth of the fluid above the top of the wall
    wet = min(surface, height)
    thrust = gamma * (wet * wet / 2 + dry * wet)
    moment = gamma * (wet**3 / 6 + dry * wet * wet / 2)
    limit = min(friction * weight / thrust, weight * base / 2 / moment)
    load = f"fluid: 6 kN/m3, face: 180 deg, surface: {surface} m, all: true"
    assert factor_of(build, scene, load) == pytest.approx(limit, rel=ACCURACY)
    stands = Stability.STABLE if limit > 1.0 else Stability.UNSTABLE
    assert verdict_of(build, scene, load) is stands


def test_water_may_be_written_by_its_density_and_reaches_to_the_top_unless_its_surface_is_given() -> None:
    build, scene = wall(1.0, 2.0, 0.6, 4)
    plain = factor_of(build, scene, "fluid: 9.81 kN/m3, face: 0 deg, surface: 2 m, all: true")
    assert plain == pytest.approx(min(0.6 * 39240 / 19620, 39240 / 2 / (9810 * 8 / 6)), rel=ACCURACY)
    assert factor_of(build, scene, "fluid: 1000 kg/m3, face: 0 deg, all: true") == pytest.approx(plain, rel=ACCURACY)


def test_a_fluid_presses_on_a_battered_face_across_it() -> None:
    # A dam with a face at 60 deg: the weight of the water over the face counts for the dam.
    h, slope, gamma = 2.0, radians(60), 9810.0
    run = h / tan(slope)
    outline = f"[[0 m, 0 m], [{0.5 + run} m, 0 m], [0.5 m, {h} m], [0 m, {h} m]]"
    dam = f"{{prism: {{outline: {outline}, depth: 1 m}}, density: 2000 kg/m3}}"
    build = f"- bricks: [{{name: dam, at: [0 m, 0 m, 0 m], brick: {dam}}}]"
    area_x = 0.5 * h * 0.25 + run * h / 2 * (0.5 + run / 3)  # first moment of the section about the toe
    weight, held = 2000 * 9.81 * (0.5 * h + run * h / 2), 2000 * 9.81 * area_x
    push, pressed_down = gamma * h * h / 2, gamma * run * h / 2
    # about the toe at x = 0: the water's weight acts at x = 0.5 + 2/3 run
    overturns = held / (push * h / 3 - pressed_down * (0.5 + run * 2 / 3)) if push * h / 3 > pressed_down else 1e9
    slides = 0.6 * weight / (push - 0.6 * pressed_down)
    found = factor_of(build, "\nfriction: 0.6", "fluid: 9.81 kN/m3, face: 0 deg, brick: dam")
    assert found == pytest.approx(slides if overturns < 0 else min(slides, overturns), rel=ACCURACY)


@pytest.mark.parametrize("turn", [0.0, 20.0, 45.0])
def test_a_block_tips_in_the_wind_at_the_pressure_on_the_area_that_the_wind_sees(turn: float) -> None:
    # The wind sees B sin + D cos of the width. A turned block tips over an edge, against a part of the drag.
    build = f"- bricks: [{{name: block, at: [0 m, 0 m, 0.45 m], rotate: [0 deg, 0 deg, {turn} deg]}}]"
    angle = radians(turn)
    drag = H * (B * abs(sin(angle)) + D * cos(angle))
    # Tipping needs the drag moment p A H / 2, about the edge of the face ahead: lever W B / 2, of the part across it.
    tips = min(W * B / 2 / cos(angle), W * D / 2 / sin(angle) if turn else 1e9) / (drag * H / 2)
    found = 100.0 * factor_of(build, BLOCK, "wind: 100 Pa, towards: 0 deg, brick: block")
    assert found == pytest.approx(tips, rel=ACCURACY)
    assert found == pytest.approx(100.0 * factor_of(build, BLOCK, "wind: 100 Pa, towards: 0 deg, all: true"))


def test_wind_presses_on_no_face_that_another_brick_or_a_wall_covers() -> None:
    row = "- bricks: [{name: a, at: [0 m, 0 m, 0.45 m]}, {name: b, at: [0.3 m, 0 m, 0.45 m]}]"
    # Both blocks as one, 2 B thick, would tip later; the block behind only has to be pushed over by the first.
    alone = factor_of(ON_THE_GROUND, BLOCK, "wind: 100 Pa, towards: 0 deg, all: true")
    both = factor_of(row, BLOCK, "wind: 100 Pa, towards: 0 deg, all: true")
    ahead = factor_of(row, BLOCK, "pressure: 100 Pa, face: 180 deg, brick: a")
    assert both == pytest.approx(ahead, rel=ACCURACY)
    assert both > 1.5 * alone
    sheltered = f"{BLOCK}\nworld: {{walls: [{{bearing: 180 deg, distance: 150 mm}}]}}"
    assert (
        factor_of(ON_THE_GROUND, sheltered, "weight: 1 N, brick: block", "wind: 1 kPa, towards: 0 deg, all: true") > 1e6
    )
    # A step: the upper block covers half of the face of neither; wind on the step of the lower one does not see it.
    tower = "- bricks: [{name: a, at: [0 m, 0 m, 0.45 m]}, {name: b, on: a, offset: [0 m, 0.1 m, 0 m]}]"
    drag = 2 * D * H
    assert factor_of(tower, BLOCK, "wind: 100 Pa, towards: 0 deg, all: true") == pytest.approx(
        2 * W * B / 2 / (100 * drag * H), rel=ACCURACY
    )


@pytest.mark.parametrize(("towards", "half"), [(0.0, B / 2), (pi / 2, D / 2), (pi, B / 2)])
def test_an_acceleration_tips_a_block_at_its_slenderness_and_slides_it_at_its_friction(
    towards: float, half: float
) -> None:
    load = f"acceleration: 0.1 g, towards: {towards} rad, all: true"
    limit = min(2 * half / H, MU) * 9.81 / 9.80665
    assert factor_of(ON_THE_GROUND, BLOCK, load) == pytest.approx(limit / 0.1, rel=ACCURACY)


def test_an_acceleration_acts_on_the_mass_of_each_brick() -> None:
    light = "{name: b, on: a, brick: {size: [0.3 m, 0.4 m, 0.9 m], mass: 1 kg}}"
    tower = f"- bricks: [{{name: a, at: [0 m, 0 m, 0.45 m]}}, {light}]"
    mass = W / 9.81
    height = (mass * H / 2 + 1.5 * H) / (mass + 1)
    found = factor_of(tower, BLOCK, "acceleration: 1 m/s2, towards: 0 deg, bricks: [a, b]")
    assert found == pytest.approx(9.81 * B / 2 / height, rel=ACCURACY)


@pytest.mark.parametrize(
    ("load", "code", "words"),
    [
        ("^{wind: 1 kPa, all: true}", "SD102", "no direction"),
        ("^{fluid: 10 kN/m3, all: true}", "SD102", "no `face`"),
        ("{fluid: ^10 kPa, face: 0 deg, all: true}", "SD106", "a weight per volume"),
        ("{fluid: 10 kN/m3, face: 0 deg, all: true, surface: ^-1 m}", "SD207", "not above the loaded bricks"),
        ("{acceleration: ^1 m/s, towards: 0 deg, all: true}", "SD106", "an acceleration"),
        ("^{wind: 1 kPa, towards: 0 deg, all: true, level: 1}", "SD108", "exactly one"),
        ("^{wind: 1 kPa, towards: 0 deg, brick: block, point: [0 m, 0 m, 0 m]}", "SD108", "does not apply"),
        ("^{weight: 1 kg, all: true, surface: 1 m}", "SD108", "`surface` does not apply"),
    ],
)
def test_a_mistake_in_a_field_is_told_at_its_place(load: str, code: str, words: str) -> None:
    (mistake,) = mistakes_of(ON_THE_GROUND, f"{BLOCK}\nloads: [{load.replace('^', '')}]")
    assert (mistake.code, mistake.span.column) == (code, len("loads: [") + load.index("^") + 1)
    assert words in mistake.message
    assert mistake.hint


def test_amounts_of_all_kinds_may_be_variables() -> None:
    variables = "\nlet: {p: 1 kPa, t: 1 N*m, q: 1 kN/m, w: 10 kN/m3, a: 1 m/s2}"
    loads = (
        'pressure: "${p}", face: 180 deg, all: true',
        'wind: "${p / 2}", towards: 0 deg, all: true',
        'moment: "${t}", about: 90 deg, all: true',
        'line: "${q}", towards: 0 deg, brick: block, from: [0 m, 0 m, 0 m], to: [0 m, 0.1 m, 0 m]',
        'fluid: "${2 * w}", face: 180 deg, all: true',
        'acceleration: "${a}", towards: 0 deg, all: true',
    )
    tipping = (1000 + 500) * D * H * H / 2 + 1 + 100 * H / 2 + 20000 * D * H**3 / 6 + W / 9.81 * H / 2
    found = factor_of(ON_THE_GROUND, BLOCK + variables, *loads)
    assert found == pytest.approx(W * B / 2 / tipping, rel=ACCURACY)
