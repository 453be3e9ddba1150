"""The arch: where its stones lie, and that it stands from the thickness on at which a line of thrust fits into it."""

from collections.abc import Sequence
from math import hypot, pi

import pytest
from scipy.optimize import brentq

from stability.model import GROUND, Brick, Plane, Pose
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed, Stability
from stackdsl.language.brick_forms import Form, box_form, laid
from stackdsl.language.layouts.arch import ArchParams
from stackdsl.language.layouts.flat_arch import FlatArchParams
from stackdsl.language.layouts.registry import BrickSpec, place
from stackdsl.language.mistakes import MistakeError
from tests.stackdsl.language.layouts.thrust_lines import MILANKOVITCH, Point, joints_of, least_thickness, room

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


def stands(specs: tuple[BrickSpec, ...], friction: float) -> bool:
    """Whether all stones stand, set down together on ground of the same friction."""
    assembly = Assembly([Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction)], friction)
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


def test_a_flat_arch_has_its_crown_at_its_rise_and_abutments_that_carry_its_ends() -> None:
    left, right, *stones = arch(thickness="60 mm", voussoirs=10, rise="200 mm", abutment="400 mm")
    crown = (stones[4].outline or ())[3]
    assert crown == pytest.approx((0.0, 0.2))
    assert left.outline is not None
    for own, other in zip(left.outline[:2], (stones[0].outline or ())[:2], strict=True):
        assert own == pytest.approx(other, abs=1e-15)
    assert min(x for x, _ in left.outline) == pytest.approx(left.outline[1][0] - 0.4)
    assert [spec.level for spec in (left, right, *stones)] == [1, 1] + [2] * 10
    assert [spec.together for spec in stones] == [False] + [True] * 9


@both_sides
@pytest.mark.parametrize("stones", [5, 8, 12, 21, 40])
def test_a_semicircle_of_few_stones_stands_from_the_thickness_on_that_holds_a_line_of_thrust(
    stones: int, share: float, stands: bool
) -> None:
    thickness = share * least_thickness(SPAN, 0.5 * SPAN, stones)
    assert _stands(arch(thickness=f"{thickness!r} m", voussoirs=stones), ROUGH) is stands


@both_sides
def test_a_semicircle_of_many_stones_stands_from_the_thickness_of_milankovitch_on(share: float, stands: bool) -> None:
    # t = 0.10748 R of the mean radius R, where span = 2 R - t. With 100 stones, the hinges are hardly out of place.
    thickness = share * SPAN * MILANKOVITCH / (2.0 - MILANKOVITCH)
    assert _stands(arch(thickness=f"{thickness!r} m", voussoirs=100), ROUGH) is stands


def _stands(specs: tuple[BrickSpec, ...], friction: float) -> bool:
    return stands(specs, friction)


def test_the_line_of_thrust_of_many_stones_needs_what_milankovitch_found() -> None:
    thickness = least_thickness(SPAN, 0.5 * SPAN, 400)
    assert thickness / (0.5 * (SPAN + thickness)) == pytest.approx(MILANKOVITCH, rel=1e-4)


@both_sides
def test_a_thick_semicircle_stands_from_the_friction_on_that_its_thrust_needs(share: float, stands: bool) -> None:
    joints = joints_of(SPAN, 0.5 * SPAN, 0.15, 12)
    least = least_friction(joints)
    assert 0.1 < least < 0.6
    assert _stands(arch(thickness="150 mm", voussoirs=12), share * least) is stands


def test_a_flat_arch_between_heavy_abutments_stands_and_between_light_ones_slides_apart() -> None:
    keys = {"thickness": "80 mm", "voussoirs": 12, "rise": "150 mm"}
    assert stands(arch(**keys, abutment="1 m"), 0.7)
    assert not stands(arch(**keys, abutment="50 mm"), 0.7)


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
        ({"rise": "600 mm"}, "half its span is 500 mm"),
        ({"rise": "200 mm"}, "flatter than a semicircle"),
        ({"abutment": "200 mm"}, "stands on the ground by itself"),
    ],
)
def test_an_arch_that_cannot_be_is_refused(keys: dict[str, object], cause: str) -> None:
    with pytest.raises(MistakeError, match=cause):
        arch(thickness="60 mm", voussoirs=12, **keys)


def test_the_joints_of_the_independent_line_of_thrust_are_those_of_the_arch() -> None:
    specs = arch(thickness="60 mm", voussoirs=10, rise="200 mm", abutment="400 mm")[2:]
    for spec, ((ix, iy), (ox, oy)) in zip(specs, joints_of(SPAN, 0.2, 0.06, 10), strict=False):
        assert spec.outline is not None
        assert [*spec.outline[0], *spec.outline[1]] == pytest.approx([ix, iy, ox, oy])
    assert joints_of(SPAN, 0.5, 0.06, 10)[0][0] == pytest.approx((0.5 * SPAN * -1.0, 0.0), abs=pi * 1e-16)
