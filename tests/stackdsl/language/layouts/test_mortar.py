"""Mortar in layouts: the space and the mass that its joints take, and the strength of its joints."""

from itertools import pairwise
from math import cos, inf, pi, sin

import numpy as np
import pytest

from stability.joints import Bond
from stability.statics.elastic_joints import elastic_factor
from stackdsl.judging.proofs import finished_structure_of, margins_of_assembly
from stackdsl.timeline import Timeline
from tests.scenes import mistakes_of, timeline_of

STONE = "\nbrick: {size: [240 mm, 115 mm, 52.5 mm], density: 1800 kg/m3}"
BOND = "bond: {tension: 0.1 MPa, cohesion: 0.2 MPa}"


def mortar(thickness: str, more: str = "") -> str:
    """The keys of a layout in mortar."""
    return f"mortar: {{thickness: {thickness}, {more}{BOND}}}"


def top_of(timeline: Timeline) -> float:
    return max(each.pose.position_W[2] + each.brick.shape.reach((0.0, 0.0, 1.0)) for each in timeline.placements)


def mass_of(timeline: Timeline) -> float:
    return sum(each.brick.mass for each in timeline.placements)


def test_mortar_makes_a_wall_higher_and_longer_by_its_joints_and_fills_them_with_its_mass() -> None:
    wall = timeline_of(f"- wall: {{levels: 4, bricks: 2, {mortar('10 mm', 'density: 1500 kg/m3, ')}}}", STONE)
    assert top_of(wall) == pytest.approx(4 * 0.0625, abs=1e-12)
    x = [each.pose.position_W[0] for each in wall.placements]
    assert x[:5] == pytest.approx([-0.125, 0.125, -0.1875, 0.0, 0.1875])  # pitch 250 mm; halves of 115 mm at the ends
    bricks = 1800.0 * 0.115 * 0.0525 * (6 * 0.240 + 4 * 0.115)
    joints = 1500.0 * 0.115 * (2 * 4 * 0.250 * 0.0625 - 0.0525 * (6 * 0.240 + 4 * 0.115))
    assert mass_of(wall) == pytest.approx(bricks + joints, rel=1e-12)


def test_mortar_has_the_density_of_the_brick_unless_it_is_written() -> None:
    for weight in ("density: 1800 kg/m3", f"mass: {1800 * 0.24 * 0.115 * 0.0525} kg"):
        brick = f"\nbrick: {{size: [240 mm, 115 mm, 52.5 mm], {weight}}}"
        column = timeline_of(f"- column: {{levels: 3, {mortar('10 mm')}}}", brick)
        assert mass_of(column) == pytest.approx(1800.0 * 3 * 0.24 * 0.115 * 0.0625, rel=1e-9)
        assert top_of(column) == pytest.approx(3 * 0.0625, abs=1e-12)


@pytest.mark.parametrize(
    "layout",
    [
        "four_stack: {levels: 3",
        "jenga: {levels: 3, bricks: 2",
        "pyramid: {levels: 3",
        "corbel: {levels: 3, share: 50 %, gap: 1 cm",
        "tower: {levels: 3, bricks: 6, overlap: 25 %",
    ],
)
def test_mortar_lies_between_the_levels_of_other_layouts(layout: str) -> None:
    dry, laid = (timeline_of(f"- {layout}{mortar}}}", STONE) for mortar in ("", f", {mortar('10 mm')}"))
    assert top_of(dry) == pytest.approx(3 * 0.0525, abs=1e-12)
    assert top_of(laid) == pytest.approx(3 * 0.0625, abs=1e-12)
    if "pyramid" not in layout:  # whose mortar also lies between the ends
        assert [each.pose.position_W[:2] for each in laid.placements] == [
            each.pose.position_W[:2] for each in dry.placements
        ]


def test_the_stones_of_an_arch_leave_room_for_mortar() -> None:
    keys = "span: 2 m, thickness: 0.2 m, voussoirs: 11, depth: 0.5 m"
    dry, laid = (
        timeline_of(f"- arch: {{{keys}{more}}}", STONE)
        for more in ("", f", {mortar('12 mm', 'density: 1200 kg/m3, ')}")
    )
    assert [each.pose for each in laid.placements] == [each.pose for each in dry.placements]
    assert [each.brick.shape for each in laid.placements] == [each.brick.shape for each in dry.placements]
    joint = 0.012 * 0.2 * 0.5
    for one, other in zip(dry.placements, laid.placements, strict=True):
        assert one.brick.mass - other.brick.mass == pytest.approx(600.0 * joint, rel=1e-9)
    flat = timeline_of(
        f"- flat_arch: {{span: 2 m, height: 1 m, thickness: 0.3 m, voussoirs: 7, abutment: 1 m, {mortar('1 cm')}}}",
        STONE,
    )
    assert len(flat.placements) == 9


def test_mortar_joins_the_bricks_of_its_layout_and_what_they_are_laid_on() -> None:
    timeline = timeline_of(
        f"- {{name: low, wall: {{levels: 2, bricks: 2, {mortar('10 mm')}}}}}\n"
        "- {name: dry, column: {levels: 1, origin: [0 mm, 0 mm, 125 mm]}}\n"
        "- {name: top, column: {levels: 2, origin: [0 mm, 0 mm, 177.5 mm], mortar: {thickness: 5 mm, "
        "bond: {tension: 1 MPa, cohesion: 2 MPa, shear: 3 MPa}}}}",
        STONE + "\njoints: [{between: [top.L2.1, top.L1.1], dry: true}]",
    )
    joints, strong = timeline.world.joints, Bond(1e6, 2e6, 3e6)
    assert joints.of("low.L1.1", "low.L2.2") == joints.of("low.L1.1", "ground") == Bond(1e5, 2e5, inf)
    assert joints.of("low.L2.2", "dry.L1.1") is None
    assert joints.of("dry.L1.1", "top.L1.1") == strong
    assert joints.of("top.L1.1", "top.L2.1") is None  # an item of `joints` counts first


@pytest.mark.parametrize(
    ("build", "rest", "code", "message"),
    [
        ("wall: {levels: 2, bricks: 2, mortar: 10 mm}", "", "SD102", "the mortar has no strength"),
        (
            f"wall: {{levels: 2, bricks: 2, gap: 1 mm, {mortar('1 cm')}}}",
            "",
            "SD108",
            "mortar fills the joints",
        ),
        (
            f"wall: {{levels: 2, bricks: 2, {mortar('6 cm')}}}",
            "",
            "SD104",
            "thicker than the bricks",
        ),
        (
            f"arch: {{span: 1 m, thickness: 10 cm, voussoirs: 40, {mortar('4 cm')}}}",
            "",
            "SD104",
            "leave nothing of stones",
        ),
        (f"harmonic: {{bricks: 2, {mortar('1 cm')}}}", "", "SD101", "mortar"),
        (
            f"column: {{levels: 2, {mortar('1 cm')}}}",
            "\nsystems: [tuned]",
            "SD211",
            "plays no joints",
        ),
    ],
)
def test_mistakes_with_mortar_are_told(build: str, rest: str, code: str, message: str) -> None:
    mistake, *others = mistakes_of(f"- {build}", STONE + rest)
    assert others == []
    assert mistake.code == code
    assert message in mistake.message
    assert mistake.hint


def test_an_item_of_joints_may_give_the_strength_of_mortar() -> None:
    joints = timeline_of(
        "- {name: w, wall: {levels: 2, bricks: 2, mortar: 10 mm}}", f"{STONE}\njoints: [{{of: w, {BOND}}}]"
    ).world.joints
    assert joints.of("w.L1.1", "w.L2.1") == Bond(1e5, 2e5)


def test_a_leaning_mortared_column_bears_its_plastic_moment() -> None:
    # About the lower edge: strength f of the bed, over half its width, against the moment of the weight.
    angle, height, width = 12.0 * pi / 180.0, 20 * 0.0625, 0.115
    column = timeline_of(
        "- column: {levels: 20, mortar: {thickness: 10 mm, bond: {tension: 0.05 MPa, cohesion: 1 MPa}}}",
        f"{STONE}\nworld: {{tilt: {{angle: 12 deg, towards: 90 deg}}}}",
    )
    weight = mass_of(column) * 9.81
    moment = weight * 0.5 * (height * sin(angle) - width * cos(angle))
    factor = 0.05e6 * 0.24 * width * width / 2.0 / moment
    found = margins_of_assembly(finished_structure_of(column).assembly, ("load_factor",)).load_factor
    assert found == pytest.approx(factor, rel=1e-6)


def test_a_brittle_arch_bears_what_the_force_method_gives_for_elastic_joints() -> None:
    span, thickness, count, depth, density, tension = 4.0, 0.15, 21, 0.5, 1800.0, 1e6
    arch = timeline_of(
        f"- arch: {{span: {span} m, thickness: {thickness} m, voussoirs: {count}, depth: {depth} m, "
        "mortar: {thickness: 10 mm, bond: {tension: 1 MPa, cohesion: 10 MPa, brittle: true}}}",
        STONE,
    )
    angles = [pi - pi * number / count for number in range(count + 1)]
    radials = [np.array((cos(angle), sin(angle))) for angle in angles]
    corners = [(0.5 * span * out, (0.5 * span + thickness) * out) for out in radials]
    weights, middles = zip(*(_wedge(*a, *b[::-1]) for a, b in pairwise(corners)), strict=True)
    area, inertia = thickness * depth, depth * thickness**3 / 12.0
    left = (corners[0][0] + corners[0][1]) / 2.0
    compliance, shift, stresses = np.zeros((3, 3)), np.zeros(3), []
    for number, out in enumerate(radials):  # forces at the left springing, on the part to the right of each joint
        (x, y), (a, b) = (corners[number][0] + corners[number][1]) / 2.0 - left, out
        before = depth * density * 9.81 * np.array(weights[:number])
        load = before.sum()
        moment = float(before @ [x + left[0] - middle for middle in middles[:number]])
        pressed, sheared = (np.array((b, -a, 0.0)), load * a), (np.array((a, b, 0.0)), -load * b)
        bent = np.array((y, -x, 1.0)), moment
        for (unit, constant), stiffness in ((pressed, area), (sheared, 0.4 * area), (bent, inertia)):
            compliance += np.outer(unit, unit) / stiffness
            shift += unit * constant / stiffness
        stresses.append((pressed, bent))
    redundant = -np.linalg.solve(compliance, shift)
    largest = max(
        abs(bent[0] @ redundant + bent[1]) * thickness / 2.0 / inertia - (pressed[0] @ redundant + pressed[1]) / area
        for pressed, bent in stresses
    )
    found = elastic_factor(finished_structure_of(arch).assembly.problem())
    assert found == pytest.approx(tension / largest, rel=1e-9)


def _wedge(*outline: np.ndarray) -> tuple[float, float]:
    """The area of an outline, and the x of its centroid."""
    doubled = [
        (p[0] * q[1] - q[0] * p[1], p[0] + q[0]) for p, q in zip(outline, (*outline[1:], outline[0]), strict=True)
    ]
    area = sum(part for part, _ in doubled) / 2.0
    return abs(area), sum(part * along for part, along in doubled) / (6.0 * area)
