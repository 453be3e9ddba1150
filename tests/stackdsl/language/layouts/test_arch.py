"""The arch: where its stones lie, and that it stands from the thickness on at which a line of thrust fits into it."""

from collections.abc import Sequence
from math import hypot, pi, radians, sin, tan

import pytest
from scipy.optimize import brentq

from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly
from stackdsl.language.bricks import Form, box_form, laid
from stackdsl.language.layouts.arch import ArchParams
from stackdsl.language.layouts.flat_arch import FlatArchParams
from stackdsl.language.layouts.registry import BrickSpec, place
from stackdsl.language.quantities import InputError
from tests.stackdsl.language.layouts.thrust_lines import (
    MILANKOVITCH,
    Point,
    joints_of,
    least_thickness,
    milankovitch,
    room,
)

SPAN, DENSITY = 1.0, 2400.0
SIZE = (0.1, 0.06, 0.05)
ROUGH = 1.5  # friction that lets nothing slide
both_sides = pytest.mark.parametrize(("share", "stands"), [(1.001, True), (0.999, False)])


def arch(**keys: object) -> tuple[BrickSpec, ...]:
    return place("arch", ArchParams.model_validate({"span": "1 m", **keys}), SIZE)


def form_of(spec: BrickSpec) -> Form:
    return laid(box_form(SIZE), spec)


def placed(name: str, spec: BrickSpec) -> Placed:
    form = form_of(spec)
    (x, y, z), (px, py, pz) = form.origin, spec.position
    return Placed(Brick(name, form.shape, DENSITY * form.shape.volume), Pose((px - x, py - y, pz - z)))


def least_friction(joints: Sequence[tuple[Point, Point]]) -> float:
    """Below which no line of thrust keeps within the cones of all joints."""
    return float(brentq(lambda friction: room(joints, friction) - 1e-12, 1e-6, 3.0, xtol=1e-12))


def standing(specs: tuple[BrickSpec, ...], friction: float, of_ground: float | None = None) -> bool:
    """Whether all stones stand, set down together on ground of the same friction or of its own."""
    ground = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction if of_ground is None else of_ground)
    assembly = Assembly([ground], friction)
    stones = [placed(f"s{number:03}", spec) for number, spec in enumerate(specs)]
    verdict = assembly.add_all(stones, names_smallest=False)
    assert verdict.stability is not Stability.UNDECIDED
    return verdict.stability is Stability.STABLE


def test_the_stones_of_an_arch_reach_from_springing_to_springing_at_its_thickness() -> None:
    specs = arch(thickness="60 mm", voussoirs=9)
    assert len(specs) == 9
    inner = [spec.outline[0] for spec in specs if spec.outline] + [(specs[-1].outline or ())[3]]
    outer = [spec.outline[1] for spec in specs if spec.outline] + [(specs[-1].outline or ())[2]]
    assert [hypot(x, z) for x, z in inner] == pytest.approx([0.5] * 10)
    assert [hypot(x, z) for x, z in outer] == pytest.approx([0.56] * 10)
    assert [*inner[0], *inner[-1]] == pytest.approx([-0.5, 0.0, 0.5, 0.0])
    assert all(spec.depth == SIZE[1] for spec in specs)


@pytest.mark.parametrize(("keys", "height"), [({}, 0.06), ({"height": "350 mm"}, 0.35)])
def test_a_flat_arch_springs_above_the_ground_from_abutments_that_carry_its_ends(
    keys: dict[str, object], height: float
) -> None:
    left, right, *stones = arch(thickness="60 mm", voussoirs=10, rise="200 mm", abutment="400 mm", **keys)
    crown = (stones[4].outline or ())[3]
    assert crown == pytest.approx((0.0, height + 0.2))
    assert min(z for stone in stones for _, z in stone.outline or ()) == pytest.approx(height)
    assert left.outline is not None
    for own, other in zip(left.outline[1:3], (stones[0].outline or ())[:2], strict=True):
        assert own == pytest.approx(other, abs=1e-15)
    assert min(x for x, _ in left.outline) == pytest.approx(left.outline[2][0] - 0.4)
    assert [spec.level for spec in (left, right, *stones)] == [1, 1] + [2] * 10
    assert [spec.together for spec in stones] == [False] + [True] * 9


@both_sides
@pytest.mark.parametrize("stones", [5, 8, 12, 21, 40])
def test_a_semicircle_of_few_stones_stands_from_the_thickness_on_that_holds_a_line_of_thrust(
    stones: int, share: float, stands: bool
) -> None:
    thickness = share * least_thickness(SPAN, 0.5 * SPAN, stones)
    assert standing(arch(thickness=f"{thickness!r} m", voussoirs=stones), ROUGH) is stands


@both_sides
def test_a_semicircle_of_many_stones_stands_from_the_thickness_of_milankovitch_on(share: float, stands: bool) -> None:
    # t = 0.10748 R of the mean radius R, where span = 2 R - t. With 100 stones, the hinges are hardly out of place.
    thickness = share * SPAN * MILANKOVITCH / (2.0 - MILANKOVITCH)
    assert standing(arch(thickness=f"{thickness!r} m", voussoirs=100), ROUGH) is stands


MANY = (6, 7, 8, 12, 21, 40, 60)
HALF_ANGLES = (20.0, 30.0, 45.0, 60.0, 75.0)  # between the crown and the springings [deg]


def springing(half_angle: float, thickness: float, stones: int) -> tuple[BrickSpec, ...]:
    """An arch between abutments that are heavy, from springings so far from its crown [deg]."""
    rise = rise_of(half_angle)
    return arch(thickness=f"{thickness!r} m", voussoirs=stones, rise=f"{rise!r} m", abutment="3 m")


def rise_of(half_angle: float) -> float:
    return 0.5 * SPAN * tan(0.5 * radians(half_angle))


@both_sides
@pytest.mark.parametrize("half_angle", HALF_ANGLES)
@pytest.mark.parametrize("stones", [5, *(pytest.param(many, marks=pytest.mark.slow) for many in MANY)])
def test_an_arch_on_springings_stands_from_the_thickness_on_that_holds_a_line_of_thrust(
    stones: int, half_angle: float, share: float, stands: bool
) -> None:
    # Where its lowest edges lay on the ground as well, 6 to 71 % less was enough: 0.785 mm in place of 1.593 for 12
    # stones, 45 degrees and a span of 300 mm.
    thickness = share * least_thickness(SPAN, rise_of(half_angle), stones)
    assert standing(springing(half_angle, thickness, stones), ROUGH) is stands


@both_sides
@pytest.mark.parametrize("half_angle", [45.0, *(pytest.param(a, marks=pytest.mark.slow) for a in HALF_ANGLES)])
@pytest.mark.parametrize("thickness", [0.05, *(pytest.param(t, marks=pytest.mark.slow) for t in (0.03, 0.12))])
def test_an_arch_on_springings_stands_from_the_friction_on_that_its_thrust_needs(
    thickness: float, half_angle: float, share: float, stands: bool
) -> None:
    least = least_friction(joints_of(SPAN, rise_of(half_angle), thickness, 11))
    assert standing(springing(half_angle, thickness, 11), share * least, of_ground=3.0) is stands


@both_sides
@pytest.mark.parametrize("height", ["5 mm", "300 mm"])
def test_a_semicircle_on_piers_needs_the_thickness_that_it_needs_on_the_ground(
    height: str, share: float, stands: bool
) -> None:
    thickness = share * least_thickness(SPAN, 0.5 * SPAN, 9)
    specs = arch(thickness=f"{thickness!r} m", voussoirs=9, abutment="2 m", height=height)
    assert standing(specs, ROUGH) is stands


@pytest.mark.parametrize("half_angle", [*HALF_ANGLES, 90.0])
def test_the_line_of_thrust_of_many_stones_needs_what_the_closed_form_says(half_angle: float) -> None:
    thickness = least_thickness(SPAN, rise_of(half_angle), 400)
    radius = 0.5 * SPAN / sin(radians(half_angle)) + 0.5 * thickness
    assert thickness / radius == pytest.approx(milankovitch(radians(half_angle)), rel=1e-4)


def test_the_closed_form_of_a_semicircle_is_that_of_milankovitch() -> None:
    assert milankovitch(0.5 * pi) == pytest.approx(MILANKOVITCH, abs=5e-6)


@both_sides
def test_a_thick_semicircle_stands_from_the_friction_on_that_its_thrust_needs(share: float, stands: bool) -> None:
    joints = joints_of(SPAN, 0.5 * SPAN, 0.15, 12)
    least = least_friction(joints)
    assert 0.1 < least < 0.6
    assert standing(arch(thickness="150 mm", voussoirs=12), share * least) is stands


def test_a_flat_arch_between_heavy_abutments_stands_and_between_light_ones_slides_apart() -> None:
    keys = {"thickness": "80 mm", "voussoirs": 12, "rise": "150 mm"}
    assert standing(arch(**keys, abutment="1 m"), 0.7)
    assert not standing(arch(**keys, abutment="50 mm"), 0.7)


def flat(**keys: object) -> tuple[BrickSpec, ...]:
    written = {"span": "1 m", "height": "500 mm", "thickness": "300 mm", "abutment": "300 mm", **keys}
    return place("flat_arch", FlatArchParams.model_validate(written), SIZE)


def joints_of_flat(between: Sequence[BrickSpec]) -> list[tuple[Point, Point]]:
    outlines = [stone.outline for stone in between if stone.outline]
    return [*((outline[0], outline[1]) for outline in outlines), (outlines[-1][3], outlines[-1][2])]


@both_sides
@pytest.mark.parametrize(("stones", "lean"), [(3, "20 deg"), (5, "20 deg"), (7, "35 deg"), (8, "10 deg")])
def test_a_smooth_flat_arch_stands_from_the_thickness_on_that_holds_its_line_of_thrust(
    stones: int, lean: str, share: float, stands: bool
) -> None:
    # Without friction all forces are square to the joints, so that their thrust is known, and how far their line sags.
    def fits(thickness: float) -> float:
        _, _, *between = flat(voussoirs=stones, lean=lean, thickness=f"{thickness!r} m")
        return room(joints_of_flat(between), 0.0)

    least = float(brentq(fits, 0.01, 0.4, xtol=1e-12))
    left, right, *between = flat(voussoirs=stones, lean=lean, thickness=f"{share * least!r} m")
    assembly = Assembly([], 0.0, tables=[placed(f"t{n}", end) for n, end in enumerate((left, right))])
    verdict = assembly.add_all([placed(f"s{n}", stone) for n, stone in enumerate(between)], names_smallest=False)
    assert verdict.stability is (Stability.STABLE if stands else Stability.UNSTABLE)


def test_one_wedge_between_two_slopes_needs_no_friction() -> None:
    (left, right, wedge) = flat(voussoirs=1, lean="20 deg")
    assembly = Assembly([], 0.0, tables=[placed("left", left), placed("right", right)])
    assert assembly.add_all([placed("wedge", wedge)]).stability is Stability.STABLE


@pytest.mark.parametrize(
    ("keys", "cause"),
    [
        ({"rise": "600 mm"}, "half its span, 500 mm"),
        ({"rise": "200 mm"}, "flatter than a semicircle"),
        ({"height": "200 mm"}, "applies only to arches with abutments"),
    ],
)
def test_an_arch_that_cannot_be_is_refused(keys: dict[str, object], cause: str) -> None:
    with pytest.raises(InputError, match=cause):
        arch(thickness="60 mm", voussoirs=12, **keys)


def test_the_joints_of_the_independent_line_of_thrust_are_those_of_the_arch() -> None:
    specs = arch(thickness="60 mm", voussoirs=10, rise="200 mm", abutment="400 mm")[2:]
    springing = 0.06  # above the ground
    for spec, ((ix, iy), (ox, oy)) in zip(specs, joints_of(SPAN, 0.2, 0.06, 10), strict=False):
        assert spec.outline is not None
        assert [*spec.outline[0], *spec.outline[1]] == pytest.approx([ix, iy + springing, ox, oy + springing])
    assert joints_of(SPAN, 0.5, 0.06, 10)[0][0] == pytest.approx((0.5 * SPAN * -1.0, 0.0), abs=pi * 1e-16)
