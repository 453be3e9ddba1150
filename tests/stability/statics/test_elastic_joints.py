"""Brittle joints: bricks are proven to stand by elastic stresses or without the joints, and by nothing else."""

from dataclasses import replace
from math import cos, radians, sin

import pytest

from stability.analysis.acceleration_margin import acceleration
from stability.analysis.load_factor import LoadFactor, load_factor
from stability.contact_law import OtherLawError
from stability.geometry.box import Box
from stability.geometry.vectors import about, rotate
from stability.joints import Bond, JointRule, Joints
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly
from stability.statics.elastic_joints import elastic_factor

L, W, H = 0.2, 0.1, 0.05  # [m] of each block
WEIGHT, G = 2.0, 9.81  # [N], [m/s2]
SHEAR = 1e7  # [Pa] that no joint here reaches


class Everyone(frozenset[str]):
    """All names."""

    def __contains__(self, _name: object) -> bool:
        return True


def built(
    bricks: list[Placed], bond: Bond, tables: tuple[Placed, ...] = (), planes: tuple[Plane, ...] = ()
) -> Assembly:
    joints = Joints((JointRule(bond, (Everyone(), Everyone())),))
    assembly = Assembly(planes, 0.5, G, tables=tables, joints=joints)
    assembly.add_all(bricks)
    return assembly


def block(name: str, at: Vec3, yaw: float = 0.0, size: Vec3 = (L, W, H)) -> Placed:
    return Placed(Brick(name, Box(size), WEIGHT / G), Pose(at, about((0.0, 0.0, 1.0), yaw)))


def corbel(tension: float, count: int, yaw: float = 0.0) -> Assembly:
    """Blocks glued end to end out of a wall, along a bearing."""
    turned = about((0.0, 0.0, 1.0), yaw)
    wall = Placed(Brick("wall", Box((1.0, 1.0, 2.0)), 1.0), Pose(rotate(turned, (-0.5, 0.0, 0.0)), turned))
    blocks = [block(f"b{n}", rotate(turned, ((n + 0.5) * L, 0.0, 0.0)), yaw) for n in range(count)]
    return built(blocks, Bond(tension, SHEAR, brittle=True), (wall,))


def factor_of(assembly: Assembly) -> LoadFactor:
    found = load_factor(assembly.problem())
    assert found is not None
    return found


@pytest.mark.parametrize("yaw", [0.0, 0.7])
@pytest.mark.parametrize("count", [1, 3])
def test_a_corbel_bears_by_its_elastic_stresses_a_third_of_what_ductile_joints_bear(count: int, yaw: float) -> None:
    # Bending: f w h^2 / 6 = n^2 W L / 2. Plastic: f w h^2 / 2 about the lower edge.
    assembly = corbel(1e5, count, yaw)
    elastic = 1e5 * W * H * H / (3.0 * count * count * WEIGHT * L)
    assert elastic_factor(assembly.problem()) == pytest.approx(elastic, rel=1e-9)
    found = factor_of(assembly)
    assert found.factor == pytest.approx(elastic, rel=1e-9)
    assert found.too_large == pytest.approx(3.0 * elastic, rel=1e-6)


@pytest.mark.parametrize(
    ("times", "stability"),
    [(1.001, Stability.STABLE), (0.999, Stability.UNDECIDED), (0.34, Stability.UNDECIDED), (0.33, Stability.UNSTABLE)],
)
def test_the_verdict_is_open_between_the_elastic_and_the_ductile_limit(times: float, stability: Stability) -> None:
    needed = 3.0 * WEIGHT * L / (W * H * H)
    verdict = corbel(times * needed, 1).verdict()
    assert verdict.stability is stability
    if stability is Stability.UNDECIDED:
        assert verdict.moving == ("b0",)
        assert verdict.reason.startswith("brittle joints may break")


def test_uniform_stresses_use_the_whole_strength() -> None:
    ceiling = Placed(Brick("ceiling", Box((1.0, 1.0, 1.0)), 1.0), Pose((0.0, 0.0, 0.5)))
    hanging = built([block("b", (0.0, 0.0, -0.5 * H))], Bond(1e3, SHEAR, brittle=True), (ceiling,))
    assert factor_of(hanging).factor == pytest.approx(1e3 * L * W / WEIGHT, rel=1e-9)
    walls = tuple(
        Placed(Brick(f"wall{side:+g}", Box((1.0, 1.0, 1.0)), 1.0), Pose((side * (0.5 + 0.5 * L), 0.0, 0.0)))
        for side in (-1.0, 1.0)
    )
    between = built([block("b", (0.0, 0.0, 0.0))], Bond(1e4, 500.0, brittle=True), walls)
    assert factor_of(between).factor == pytest.approx(2.0 * 500.0 * W * H / WEIGHT, rel=1e-9)


def leaning(angle: float, bond: Bond) -> Assembly:
    """A post glued to ground that is tilted towards +x."""
    turned, size = about((0.0, 1.0, 0.0), angle), (W, W, 0.5)
    ground = Plane(GROUND, (0.0, 0.0, 0.0), rotate(turned, (0.0, 0.0, 1.0)), 0.5)
    post = Placed(Brick("post", Box(size), WEIGHT / G), Pose(rotate(turned, (0.0, 0.0, 0.25)), turned))
    return built([post], bond, planes=(ground,))


def test_a_structure_that_stands_without_its_brittle_joints_stands_whichever_of_them_break() -> None:
    # The weight acts within the foot, and beyond its middle third: an elastic joint pulls at its upper edge.
    weak = leaning(radians(8.0), Bond(1.0, SHEAR, brittle=True))
    assert elastic_factor(weak.problem()) < 1.0
    assert weak.verdict().stability is Stability.STABLE
    # Beyond the foot, the elastic joint has to bear the pull: (M / (a^3 / 6) - N / a^2).
    angle = radians(14.0)
    pull = WEIGHT * (0.25 * sin(angle) * 6.0 / W**3 - cos(angle) / W**2)
    for times, stability in ((1.001, Stability.STABLE), (0.999, Stability.UNDECIDED)):
        assert leaning(angle, Bond(times * pull, SHEAR, brittle=True)).verdict().stability is stability


@pytest.mark.parametrize(("times", "stability"), [(1.001, Stability.STABLE), (0.999, Stability.UNDECIDED)])
def test_shear_is_borne_by_cohesion_and_by_friction_at_the_corner_that_is_pressed_least(
    times: float, stability: Stability
) -> None:
    angle, foot = radians(35.0), W * W
    least_pressed = WEIGHT * (cos(angle) / foot - 6.0 * 0.25 * sin(angle) / W**3)  # it pulls
    cohesion = WEIGHT * sin(angle) / foot - 0.5 * least_pressed
    assert leaning(angle, Bond(1e6, times * cohesion, brittle=True)).verdict().stability is stability


def test_a_dry_contact_that_would_have_to_pull_is_no_elastic_proof() -> None:
    wall = Placed(Brick("wall", Box((1.0, 1.0, 2.0)), 1.0), Pose((-0.5, 0.0, 0.0)))
    bond = Bond(1e6, SHEAR, brittle=True)
    joints = Joints((JointRule(bond, (frozenset({"b0"}), frozenset({"wall"}))),))
    assembly = Assembly((), 0.5, G, tables=(wall,), joints=joints)
    assembly.add(*_parts(block("b0", (0.5 * L, 0.0, 0.0))))
    assert assembly.verdict().stability is Stability.STABLE
    verdict = assembly.add(*_parts(block("b1", (0.5 * L, 0.0, -H))))  # it hangs dry
    assert verdict.stability is Stability.UNSTABLE
    assert elastic_factor(assembly.problem()) == 0.0


def _parts(placed: Placed) -> tuple[Brick, Pose]:
    return placed.brick, placed.pose


def test_ductile_bonds_are_judged_as_before() -> None:
    assembly = corbel(1e5, 1)
    ductile = [replace(contact, brittle=None) for contact in assembly.problem().contacts]
    found = load_factor(replace(assembly.problem(), contacts=tuple(ductile)))
    assert found is not None
    assert found.factor == pytest.approx(1e5 * W * H * H / (WEIGHT * L), rel=1e-6)


def test_accelerations_of_brittle_joints_are_refused() -> None:
    with pytest.raises(OtherLawError, match="not computed for brittle joints"):
        acceleration(corbel(1e6, 1).problem())
