"""Load factors of joined bricks against closed forms, proven on both sides, and the joint that gives way."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import cos, inf, pi, radians, sin
from random import Random

import pytest

from benchmarks.joined import FRICTION, KINDS, assembly_of, drawn
from benchmarks.joined_programs import load_factors
from stability.analysis.acceleration_margin import acceleration
from stability.analysis.joined_acceleration import acceleration_of_joined
from stability.analysis.load_factor import LoadFactor, load_factor
from stability.analysis.subset_search import Subsets
from stability.geometry.box import Box
from stability.geometry.vectors import about, rotate
from stability.joints import DRY, Bond, Joint, JointRule, Joints, Pull, Studs, studs_meet
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import ZERO, Placed, Stability, Tolerances, Verdict, Wrench
from stability.statics.assembly import Assembly

WEIGHT, G = 2.0, 9.81  # [N] of each brick, [m/s2]
CLOSE = 1e-6
EXACT = Tolerances()
LENGTH, WIDTH, HEIGHT = 0.2, 0.1, 0.05  # [m]
AREA = LENGTH * WIDTH


def brick(name: str, at: Vec3, size: Vec3 = (LENGTH, WIDTH, HEIGHT), yaw: float = 0.0) -> Placed:
    return Placed(Brick(name, Box(size), WEIGHT / G), Pose(at, about((0.0, 0.0, 1.0), yaw)))


CEILING = Placed(Brick("ceiling", Box((1.0, 1.0, 1.0)), 1.0), Pose((0.0, 0.0, 1.5)))
WALL = Placed(Brick("wall", Box((1.0, 1.0, 2.0)), 1.0), Pose((-0.5, 0.0, 1.0)))
FLAT = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)


class Everyone(frozenset[str]):
    """All names."""

    def __contains__(self, _name: object) -> bool:
        return True


def everywhere(joint: Joint) -> Joints:
    return Joints((JointRule(joint, (Everyone(), Everyone())),))


def assembly(
    bricks: Sequence[Placed],
    joints: Joints,
    tables: Sequence[Placed] = (),
    planes: Sequence[Plane] = (FLAT,),
    friction: float = 0.5,
) -> Assembly:
    built = Assembly(planes, friction, G, tables=tables, joints=joints)
    built.add_all(bricks)
    return built


def factor_of(built: Assembly, growing: dict[str, Wrench] | None = None) -> LoadFactor:
    factor = load_factor(built.problem(), growing)
    assert factor is not None
    return factor


# --- closed forms ----------------------------------------------------------------------------------------------------


def hanging(joint: Joint) -> Callable[[float], Assembly]:
    return lambda times: assembly(
        [brick("b", (0.0, 0.0, 1.0 - HEIGHT / 2))], everywhere(stronger(joint, times)), [CEILING]
    )


def stronger(joint: Joint, times: float) -> Joint:
    match joint:
        case Bond(tension, cohesion, shear):
            return Bond(times * tension, times * cohesion, times * shear)
        case Pull(force):
            return Pull(times * force)
        case Studs(pitch, pull, shear):
            return Studs(pitch, times * pull, times * shear)
    raise AssertionError


def corbel(bricks: int) -> tuple[Callable[[float], Assembly], float]:
    """Bricks glued end to end out of a wall; the joint at the wall bends: W n (n L / 2) = tension w h (h / 2)."""
    tension = 1e5
    row = [brick(f"b{i:02}", (LENGTH * (i + 0.5), 0.0, 1.0)) for i in range(bricks)]
    limit = tension * WIDTH * HEIGHT**2 / (WEIGHT * bricks**2 * LENGTH)
    glue = Bond(tension, 20.0 * tension)
    return lambda times: assembly(row, everywhere(stronger(glue, times)), [WALL]), limit


PITCH = 0.008


def cantilever(columns: int) -> tuple[Callable[[float], Assembly], float]:
    """A brick of 2 x 8 studs, of which some columns hold it: it tips about the edge of the base.

    Twice the pull of each column times its distance from the edge is the weight times its overhang.
    """
    pull = 0.98
    base = Placed(
        Brick("base", Box((columns * PITCH, 2 * PITCH, 0.0096)), 1.0), Pose((-0.5 * columns * PITCH, 0.0, 0.5))
    )
    long = brick("b", ((4 - columns) * PITCH, 0.0, 0.5096), (8 * PITCH, 2 * PITCH, 0.0096))
    limit = 2.0 * pull * sum(i + 0.5 for i in range(columns)) / (WEIGHT * (4 - columns))
    studs = Studs(PITCH, pull, 1e3)
    return lambda times: assembly([long], everywhere(stronger(studs, times)), [base]), limit


def slope(degrees: float) -> tuple[Callable[[float], Assembly], float]:
    """A block on a cohesive slope: its weight pulls by W (sin - mu cos) more than friction holds."""
    angle, cohesion = radians(degrees), 40.0
    turn = about((0.0, 1.0, 0.0), angle)
    up = rotate(turn, (0.0, 0.0, 1.0))
    lying = Placed(
        Brick("b", Box((LENGTH, WIDTH, HEIGHT)), WEIGHT / G), Pose(rotate(turn, (0.0, 0.0, HEIGHT / 2)), turn)
    )
    limit = cohesion * AREA / (WEIGHT * (sin(angle) - 0.5 * cos(angle)))
    return lambda times: assembly(
        [lying], everywhere(stronger(Bond(0.0, cohesion), times)), planes=[Plane(GROUND, ZERO, up, 0.5)]
    ), limit


def on_a_wall() -> tuple[Callable[[float], Assembly], float]:
    """A flat magnet on a wall of iron slides when its weight is the friction of all pulls: W = mu 4 F."""
    plate = brick("b", (0.005, 0.0, 1.0), (0.01, 0.2, 0.2))
    return lambda times: assembly([plate], everywhere(Pull(times)), [WALL], friction=0.3), 4.0 * 0.3 / WEIGHT


FORMS = {
    "hanging by glue": (hanging(Bond(300.0, 1e4)), 300.0 * AREA / WEIGHT),
    "hanging by glue that slips at its tip": (hanging(Bond(1e4, 100.0)), 2.0 * 100.0 * AREA / WEIGHT),
    "hanging by magnets": (hanging(Pull(0.7)), 4.0 * 0.7 / WEIGHT),
    "corbel of 1": corbel(1),
    "corbel of 3": corbel(3),
    "corbel of 12": corbel(12),
    "cantilever of 1 column of studs": cantilever(1),
    "cantilever of 2 columns of studs": cantilever(2),
    "cantilever of 3 columns of studs": cantilever(3),
    "cohesive slope": slope(40.0),
    "magnet on a wall": on_a_wall(),
}


@pytest.mark.parametrize("form", FORMS)
def test_a_load_factor_is_that_of_the_closed_form_with_a_proof_on_both_sides(form: str) -> None:
    built, limit = FORMS[form]
    factor = factor_of(built(1.0))
    assert factor.factor == pytest.approx(limit, rel=CLOSE)
    assert factor.too_large == pytest.approx(limit, rel=CLOSE)
    assert factor.factor <= limit * (1.0 + 1e-12)
    assert factor.too_large >= limit * (1.0 - 1e-12)
    assert factor.forces is not None
    assert factor.motion is not None


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("share", "stability"), [(-CLOSE, Stability.UNSTABLE), (CLOSE, Stability.STABLE)])
def test_joined_bricks_stand_and_fall_on_both_sides_of_the_limit(form: str, share: float, stability: Stability) -> None:
    built, limit = FORMS[form]
    judged = built((1.0 + share) / limit)
    assert judged.verdict().stability is stability
    if stability is Stability.STABLE:
        assert judged.forces() is not None


@pytest.mark.parametrize(
    ("name", "load", "limit"),
    [
        # mortar under the wall: tension 500 Pa holds 10 N, besides the weight of 2 N
        ("pulled up", Wrench((0.0, 0.0, 1.0)), 500.0 * AREA + WEIGHT),
        # rocking about an edge: H h = (W + tension A) L / 2
        ("pushed at the top", Wrench((1.0, 0.0, 0.0), (0.0, 0.5, 0.0)), (WEIGHT + 500.0 * AREA) * LENGTH / 2.0),
        # tilted: the same at half the height
        ("tilted", Wrench((1.0, 0.0, 0.0)), (WEIGHT + 500.0 * AREA) * LENGTH),
    ],
)
def test_a_mortared_wall_bears_a_growing_load_until_its_mortar_opens(name: str, load: Wrench, limit: float) -> None:
    wall = brick("wall", (0.0, 0.0, 0.5), (LENGTH, WIDTH, 1.0))
    built = assembly([wall], everywhere(Bond(500.0, 5000.0)))
    factor = factor_of(built, {"wall": load})
    assert factor.factor == pytest.approx(limit, rel=CLOSE), name
    assert factor.too_large == pytest.approx(limit, rel=CLOSE), name
    assert [(joint.lower, joint.upper) for joint in factor.joints] == [(GROUND, "wall")]


def test_the_joint_that_gives_way_is_named() -> None:
    row = [brick(f"b{i}", (LENGTH * (i + 0.5), 0.0, 1.0)) for i in range(4)]
    strong, weak = Bond(1e6, 1e7), Bond(1e4, 1e7)
    rules = (JointRule(weak, ({"b1"}, {"b2"})), JointRule(strong, (Everyone(), Everyone())))
    first = factor_of(assembly(row, Joints(rules), [WALL]))
    assert [(joint.lower, joint.upper) for joint in first.joints] == [("b1", "b2")]
    assert set(first.motion.velocity if first.motion else ()) == {"b2", "b3"}
    # two bricks beyond the weak joint: W 2 L = tension w h^2 / 2
    assert first.factor == pytest.approx(1e4 * WIDTH * HEIGHT**2 / (4.0 * WEIGHT * LENGTH), rel=CLOSE)


def test_a_dry_structure_bears_any_multiple_of_its_weight_or_none() -> None:
    lying, beyond = brick("a", (0.0, 0.0, HEIGHT / 2)), brick("a", (0.0, 0.0, HEIGHT / 2 + 0.2))
    assert factor_of(assembly([lying], DRY)).factor == inf
    falling = factor_of(assembly([beyond], DRY))
    assert (falling.factor, falling.too_large) == (0.0, 0.0)
    assert falling.motion is not None


def test_a_dry_structure_has_a_load_factor_for_a_load_that_grows_alone() -> None:
    # A block is pushed at its centre: it slides at mu W, before it tips at W L / h.
    built = assembly([brick("a", (0.0, 0.0, HEIGHT / 2))], DRY)
    factor = factor_of(built, {"a": Wrench((1.0, 0.0, 0.0))})
    assert factor.factor == pytest.approx(0.5 * WEIGHT, rel=CLOSE)
    assert factor.too_large == pytest.approx(0.5 * WEIGHT, rel=CLOSE)


def test_bricks_that_stand_without_their_joints_bear_any_multiple_of_their_weight() -> None:
    assert factor_of(assembly([brick("a", (0.0, 0.0, HEIGHT / 2))], everywhere(Bond(1.0, 1.0)))).factor == inf


# --- horizontal accelerations -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("tension", [500.0, 5000.0])
def test_a_mortared_wall_survives_the_acceleration_at_which_its_bed_opens(tension: float) -> None:
    # a W h / 2 = (W + tension A) b / 2, across its thickness b
    wall = brick("wall", (0.0, 0.0, 0.5), (LENGTH, WIDTH, 1.0))
    survived = acceleration(assembly([wall], everywhere(Bond(tension, 10.0 * tension))).problem())
    limit = (WEIGHT + tension * AREA) * WIDTH / WEIGHT
    assert survived is not None
    assert survived.value == pytest.approx(limit, rel=CLOSE)
    assert survived.upper == pytest.approx(limit, rel=CLOSE)
    assert abs(sin(survived.bearing)) == pytest.approx(1.0)


def test_a_magnet_on_the_ground_slides_alike_in_all_directions() -> None:
    flat = brick("b", (0.0, 0.0, 0.005), (0.2, 0.2, 0.01))
    survived = acceleration(assembly([flat], everywhere(Pull(1.0))).problem())
    limit = 0.5 * (WEIGHT + 4.0) / WEIGHT
    assert survived is not None
    assert limit * (1.0 - 6e-3) <= survived.value <= limit * (1.0 + 1e-9)
    assert survived.upper == pytest.approx(limit, rel=CLOSE)


@pytest.mark.parametrize("seed", range(6))
def test_the_search_for_joined_bricks_agrees_with_that_for_dry_ones(seed: int) -> None:
    draw = Random(seed)
    at = [(draw.uniform(-0.03, 0.03), draw.uniform(-0.02, 0.02)) for _ in range(3)]
    pile = [brick(f"b{i}", (x, y, (i + 0.5) * HEIGHT), yaw=draw.uniform(0.0, 3.0)) for i, (x, y) in enumerate(at)]
    problem = assembly(pile, DRY).problem()
    one, other = (
        acceleration(problem),
        acceleration_of_joined(problem, dict.fromkeys(problem.bricks, WEIGHT), 1e-3, EXACT),
    )
    assert one is not None
    assert other is not None
    assert other.value <= one.upper * (1.0 + CLOSE)
    assert other.upper >= one.value * (1.0 - CLOSE)
    assert other.value == pytest.approx(one.value, rel=5e-3)


# --- invariance ------------------------------------------------------------------------------------------------------


def branching(scale: float = 1.0, yaw: float = 0.0, mirror: float = 1.0, names: str = "abcde") -> float:
    """The load factor of a studded column with arms, of which one is glued to another."""
    unit, high = PITCH * scale, 0.0096 * scale
    turn = about((0.0, 0.0, 1.0), yaw)

    def at(name: str, x: float, y: float, level: float, size: tuple[int, int]) -> Placed:
        middle = rotate(turn, (x * unit, mirror * y * unit, (level + 0.5) * high))
        shape = Box((size[0] * unit, size[1] * unit, high))
        return Placed(Brick(name, shape, 2.0 * size[0] * size[1] * scale**3), Pose(middle, turn))

    a, b, c, d, e = list(names)
    bricks = [
        at(a, 0.0, 0.0, 0.0, (2, 2)),
        at(b, 1.0, 1.0, 1.0, (4, 2)),
        at(c, 4.0, 1.0, 2.0, (4, 2)),
        at(d, 1.0, -1.0, 1.0, (4, 2)),
        at(e, 5.0, 2.0, 1.0, (2, 4)),
    ]
    force = scale**3 * 10.0
    rules = (
        JointRule(Bond(force / unit**2, 2.0 * force / unit**2), ({b}, {d})),
        JointRule(Studs(unit, force, 5.0 * force), (Everyone(), Everyone())),
    )
    return factor_of(assembly(bricks, Joints(rules))).factor


def test_a_load_factor_does_not_depend_on_scale_yaw_mirror_or_names() -> None:
    usual = branching()
    assert 0.0 < usual < inf
    for changed in (
        branching(scale=25.0),
        branching(yaw=0.7),
        branching(yaw=pi / 2.0),
        branching(mirror=-1.0),
        branching(names="dacbe"),
    ):
        assert changed == pytest.approx(usual, rel=CLOSE)


# --- a bounded pull is spent once ------------------------------------------------------------------------------------


def test_a_pull_that_holds_each_of_two_bricks_does_not_hold_both() -> None:
    # The upper joint bears 1.5 weights; a second brick hangs from the first.
    bear = 1.5 * WEIGHT / AREA
    rules = (JointRule(Bond(bear, 100.0 * bear), ({"ceiling"}, {"a"})), JointRule(Bond(1e6, 1e8), ({"a"}, {"b"})))
    built = Assembly((FLAT,), 0.5, G, tables=[CEILING], joints=Joints(rules))
    first, second = brick("a", (0.0, 0.0, 1.0 - HEIGHT / 2)), brick("b", (0.0, 0.0, 1.0 - 1.5 * HEIGHT))
    assert built.add(first.brick, first.pose).stability is Stability.STABLE
    verdict = built.add(second.brick, second.pose)
    assert verdict.stability is Stability.UNSTABLE
    assert set(verdict.moving) == {"a", "b"}


@pytest.mark.parametrize("bear", [2.9, 3.1])
def test_bricks_set_down_one_by_one_have_the_verdict_of_all_together(bear: float) -> None:
    # Three bricks hang in a chain; each joint bears the same.
    glue = Bond(bear * WEIGHT / AREA, 1e8)
    chain = [brick(f"b{i}", (0.0, 0.0, 1.0 - (i + 0.5) * HEIGHT)) for i in range(3)]
    built = Assembly((FLAT,), 0.5, G, tables=[CEILING], joints=everywhere(glue))
    verdicts: list[Verdict] = [built.add(each.brick, each.pose) for each in chain]
    together = assembly(chain, everywhere(glue), [CEILING]).verdict().stability
    assert [verdict.stability for verdict in verdicts[:2]] == [Stability.STABLE] * 2
    assert verdicts[-1].stability is together is (Stability.STABLE if bear > 3.0 else Stability.UNSTABLE)
    if together is Stability.STABLE:
        assert built.forces() is not None


def test_a_proven_fall_does_not_cover_parts_in_which_a_joint_resists_it() -> None:
    # Without "a" brick "b" falls; with "c", from which it hangs as well, it stands.
    rules = (JointRule(Bond(1e5, 1e6), ({"a", "c"}, {"b"})), JointRule(Bond(1e5, 1e6), ({"ceiling"}, {"a", "c"})))
    high = 1.0 - HEIGHT / 2
    bricks = [
        brick("a", (-LENGTH / 2, 0.0, high)),
        brick("c", (LENGTH / 2, 0.0, high)),
        brick("b", (0.0, 0.0, high - HEIGHT)),
    ]
    parts = Subsets(assembly(bricks, Joints(rules), [CEILING]))
    assert parts.ask(parts.part_of(["b"])).stability is Stability.UNSTABLE
    for holding in ("a", "c"):
        assert parts.ask(parts.part_of(["b", holding])).stability is Stability.STABLE


def test_a_brick_falls_when_the_brick_that_it_hangs_from_is_removed() -> None:
    chain = [brick(f"b{i}", (0.0, 0.0, 1.0 - (i + 0.5) * HEIGHT)) for i in range(2)]
    built = assembly(chain, everywhere(Bond(1e5, 1e6)), [CEILING])
    assert built.verdict().stability is Stability.STABLE
    assert built.remove(["b0"]).stability is Stability.UNSTABLE


def test_a_joint_needs_a_face() -> None:
    tipped = Placed(
        Brick("b", Box((0.1, 0.1, 0.1)), 1.0), Pose((0.0, 0.0, 0.1 * 0.5**0.5), about((1.0, 0.0, 0.0), pi / 4))
    )
    built = assembly([tipped], everywhere(Bond(1e6, 1e6)))
    assert all(contact.law.is_cone for contact in built.all_contacts())


def test_studs_hold_only_where_both_grids_meet() -> None:
    lower = brick("a", (0.0, 0.0, 0.0048), (4 * PITCH, 2 * PITCH, 0.0096))
    aligned = brick("b", (PITCH, 0.0, 0.0144), (4 * PITCH, 2 * PITCH, 0.0096))
    beside = replace(aligned, pose=Pose((1.5 * PITCH, 0.0, 0.0144)))
    studs = everywhere(Studs(PITCH, 1.0, 1.0))
    points = [
        sum(len(c.points_W) for c in assembly([lower, upper], studs).contacts("b") if not c.law.is_cone)
        for upper in (aligned, beside)
    ]
    assert points == [4 * 6, 0]


def test_a_brick_one_stud_wide_grips_each_stud_with_its_own_pull() -> None:
    studs = everywhere(Studs(PITCH, 1.0, 1.0, narrow_pull=3.0))
    pulls = []
    for lower, upper in ((1, 2), (2, 1)):  # widths
        base = brick("a", (0.0, 0.0, 0.0048), (4 * PITCH, lower * PITCH, 0.0096))
        on_top = brick("b", (0.0, 0.5 * PITCH, 0.0144), (4 * PITCH, upper * PITCH, 0.0096))
        held = [c for c in assembly([base, on_top], studs).contacts("b") if not c.law.is_cone]
        pulls.append({(-4.0 * c.law.least_normal, len(c.points_W)) for c in held})
    assert pulls == [{(1.0, 16)}, {(3.0, 16)}]  # the upper one grips


def test_bricks_with_studs_side_by_side_push_at_half_height_without_friction() -> None:
    """A brick between two neighbours is not held by them: it falls, although dry bricks would be wedged in."""
    row = [brick(name, (i * PITCH, 0.0, 0.5), (PITCH, PITCH, 0.0096)) for i, name in enumerate("abc")]
    for contact in assembly(row, everywhere(Studs(PITCH, 1.0, 1.0))).contacts("b"):
        assert contact.law.friction == 0.0
        assert [round(z, 9) for _, _, z in contact.points_W] == [0.5, 0.5]


def test_studs_of_boxes_side_by_side_do_not_have_to_meet() -> None:
    size = (4 * PITCH, 2 * PITCH, 0.0096)
    lower = brick("a", (0.0, 0.0, 0.0048), size)
    upper = {"on": (PITCH, 0.0, 0.0144), "off": (0.5 * PITCH, 0.0, 0.0144), "beside": (4.5 * PITCH, 0.0, 0.0048)}
    met = {name: studs_meet(lower, brick("b", at, size), PITCH) for name, at in upper.items()}
    assert met == {"on": True, "off": False, "beside": True}


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        (Studs(PITCH, 1.0, 1.0, -1.0), "the narrow_pull of the Studs is -1.0; write a number from 0"),
        (Bond(-1.0, 1.0), "the tension of the Bond is -1.0; write a number from 0"),
        (Pull(float("nan")), "the force of the Pull is nan"),
        (Studs(0.0, 1.0, 1.0), "the pitch of the Studs is 0.0; write a number from 1e-09"),
    ],
)
def test_strengths_that_are_no_strengths_are_refused(joint: Joint, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Assembly(joints=everywhere(joint))


def test_a_wall_of_a_closed_form_would_fall_without_its_joint() -> None:
    for built, _ in FORMS.values():
        assert built(1e-6).verdict().stability is Stability.UNSTABLE


def test_a_mechanism_in_which_a_brick_moves_a_million_times_slower_than_others_is_proven() -> None:
    draw = Random(677)
    case = drawn(draw, KINDS[677 % len(KINDS)], draw.randint(2, 12))
    low, high = load_factors(case.boxes, FRICTION, case.joint_of)
    assembly, bricks = assembly_of(case)
    assembly.add_all(bricks)
    factor = load_factor(assembly.problem())
    assert factor is not None
    assert factor.motion is not None
    assert low <= factor.factor <= factor.too_large <= high
    assert factor.too_large <= (1.0 + 3e-5) * factor.factor
