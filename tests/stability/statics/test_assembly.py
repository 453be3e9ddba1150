"""Bricks that come, go and move: verdicts follow, and only what is affected is judged again."""

import subprocess
import sys
from dataclasses import replace
from math import cos, inf, pi, sin
from typing import Any

import numpy as np
import pytest

from stability.geometry.box import Box
from stability.geometry.polygons import Point2
from stability.model import BodyId, Brick, Plane, Pose
from stability.problem import Forces, Placed, Stability, Stage
from stability.statics.assembly import Assembly
from stability.statics.certificate import total_forces
from stability.statics.proof import check_forces
from stability.statics.structure import Structure
from tests.paths import ROOT
from tests.stability.statics.random_piles import FRICTION, pile_of

LENGTH, WIDTH, THICKNESS = 0.12, 0.024, 0.008


def plank(name: str, at: Point2 = (0.0, 0.0), level: int = 1, yaw: float = 0.0, mass: float = 0.0115) -> Placed:
    turn = (0.0, 0.0, sin(yaw / 2), cos(yaw / 2))
    return Placed(Brick(name, Box((LENGTH, WIDTH, THICKNESS)), mass), Pose((*at, (level - 0.5) * THICKNESS), turn))


def four_stack(levels: int) -> list[Placed]:
    half = (LENGTH - WIDTH) / 2
    return [
        plank(f"L{level}.{side > 0:d}", (0.0, side * half), level)
        if level % 2
        else plank(f"L{level}.{side > 0:d}", (side * half, 0.0), level, yaw=pi / 2)
        for level in range(1, levels + 1)
        for side in (-1, 1)
    ]


def assembly_of(*bricks: Placed) -> Assembly:
    assembly = Assembly()
    assembly.add_all(bricks)
    return assembly


def test_nothing_at_all_stands() -> None:
    assert Assembly().verdict().stability is Stability.STABLE
    assert Assembly().forces() is not None


def test_every_plank_of_a_flush_four_stack_is_proven_by_its_load_core() -> None:
    assembly = Assembly()
    for placed in four_stack(20):
        verdict = assembly.add(placed.brick, placed.pose)
        assert (verdict.stability, verdict.stage) == (Stability.STABLE, Stage.LOAD_CORE)
    assert assembly.forces() is not None
    assert assembly.shares("L20.0") == pytest.approx({"L19.0": 0.5, "L19.1": 0.5})


def test_forces_whose_small_errors_add_up_are_balanced_again(monkeypatch: pytest.MonkeyPatch) -> None:
    assembly = Assembly()
    for placed in four_stack(4):
        assembly.add(placed.brick, placed.pose)

    def slightly_wrong(*given: Any) -> Forces:  # noqa: ANN401 -- as they are
        rows = [
            [tuple((1.0 + 1e-7) * part for part in force) for (force,) in of] for of in total_forces(*given).of_contacts
        ]
        return Forces(tuple(tuple((force,) for force in of) for of in rows))  # type: ignore[misc]

    monkeypatch.setattr("stability.statics.assembly.total_forces", slightly_wrong)
    forces = assembly.forces()
    assert forces is not None
    assert check_forces(assembly.problem(), forces, assembly.tolerances).holds


#  |w| |--p--|        w holds down s, from which p hangs out
#  |----s----|
# -g---|
def counterweighted(weight: float = 0.0115) -> list[Placed]:
    return [
        plank("g"),
        plank("s", (0.5 * LENGTH - 0.01, 0.0), level=2),
        plank("p", (0.09, 0.0), level=3),
        plank("w", (0.003, 0.0), level=3, yaw=pi / 2, mass=weight),
    ]


def test_a_counterweight_that_goes_takes_the_proof_with_it() -> None:
    assembly = assembly_of(*counterweighted(weight=0.05))
    assert assembly.verdict().stability is Stability.STABLE
    verdict = assembly.remove(["w"])
    assert verdict.stability is Stability.UNSTABLE
    assert verdict.moving == ("p", "s")
    assert verdict.stage is Stage.TIPPING
    assert "tip" in verdict.reason
    left = assembly.remove(verdict.moving)
    assert left.stability is Stability.STABLE
    assert set(assembly.bricks) == {"g"}


def test_a_counterweight_that_comes_with_the_overhang_is_counted() -> None:
    assert Assembly().add_all(counterweighted(weight=0.05)).stability is Stability.STABLE
    assembly = Assembly()
    verdicts = [assembly.add(placed.brick, placed.pose).stability for placed in counterweighted(weight=0.05)]
    assert verdicts == [Stability.STABLE, Stability.STABLE, Stability.UNSTABLE, Stability.STABLE]


def test_a_plank_that_is_moved_out_too_far_tips_and_moved_back_stands_again() -> None:
    below, above = plank("a"), plank("b", (0.05, 0.0), level=2)
    assembly = assembly_of(below, above)
    out = replace(above.pose, position_W=(0.061, 0.0, above.pose.position_W[2]))
    assert assembly.move("b", out).moving == ("b",)
    assert assembly.move("b", above.pose).stability is Stability.STABLE


def test_a_plank_without_support_falls() -> None:
    verdict = assembly_of(plank("a", level=3)).verdict()
    assert (verdict.stability, verdict.moving) == (Stability.UNSTABLE, ("a",))
    assert "nothing" in verdict.reason


def test_bricks_that_stand_without_the_moving_set_keep_their_proof() -> None:
    tower = four_stack(10)
    assembly = assembly_of(*tower, plank("over", (0.08, 0.047), level=11))
    verdict = assembly.verdict()
    assert (verdict.stability, verdict.moving) == (Stability.UNSTABLE, ("over",))
    assert all(assembly.stage(placed.brick.id) is Stage.LOAD_CORE for placed in tower)


def test_adding_on_top_judges_nothing_below_again(monkeypatch: pytest.MonkeyPatch) -> None:
    assembly = assembly_of(*four_stack(50))
    found: list[BodyId] = []
    find_core = Structure.find_core

    def spied(structure: Structure, brick: BodyId) -> None:
        found.append(brick)
        find_core(structure, brick)

    monkeypatch.setattr(Structure, "find_core", spied)
    assembly.add_all([plank("top", (0.0, (LENGTH - WIDTH) / 2), level=51)])
    assert found == ["top"]
    found.clear()
    assembly.remove(["L49.0"])
    assert sorted(found) == ["L50.0", "L50.1", "top"]


@pytest.mark.parametrize("seed", range(40))
def test_after_bricks_have_gone_the_verdict_is_that_of_a_fresh_assembly(seed: int) -> None:
    generator = np.random.default_rng([7, seed])
    pile = pile_of(generator, 12, care=1.0, mixed=seed % 2 == 0)
    assembly = Assembly(friction=FRICTION)
    assembly.add_all(pile)
    order = [int(i) for i in generator.permutation(len(pile))]
    for count in range(1, 6):
        verdict = assembly.remove([pile[order[count - 1]].brick.id])
        left = [placed for number, placed in enumerate(pile) if number not in order[:count]]
        assert verdict.stability is Assembly(friction=FRICTION).add_all(left).stability
        assert verdict.stability is not Stability.STABLE or assembly.forces() is not None


def test_a_brick_slid_in_below_others_helps_them() -> None:
    # A post under the free end of an overhang that tips without it.
    assembly = assembly_of(plank("a"), plank("b", (0.07, 0.0), level=2))
    assert assembly.verdict().stability is Stability.UNSTABLE
    assert assembly.add_all([plank("post", (0.121, 0.0))]).stability is Stability.STABLE
    assert assembly.rests_on("b") == ("a", "post")


def test_two_bodies_of_one_name_are_refused() -> None:
    assembly = assembly_of(plank("a"))
    for name in ("a", "ground"):
        with pytest.raises(ValueError, match=f"two bodies with the name '{name}'"):
            assembly.add_all([plank(name, level=2)])
    with pytest.raises(LookupError, match="there is no brick 'b'"):
        assembly.remove(["b"])
    assert set(assembly.bricks) == {"a"}


@pytest.mark.parametrize(("slope", "stands"), [(0.5 - 1e-6, True), (0.5 + 1e-6, False)])
def test_a_four_stack_on_a_slope_stands_while_it_is_no_steeper_than_friction(slope: float, stands: bool) -> None:
    angle = float(np.arctan(slope))
    turn = (0.0, sin(angle / 2), 0.0, cos(angle / 2))
    ground = Plane("ground", (0.0, 0.0, 0.0), (sin(angle), 0.0, cos(angle)), friction=0.5)
    assembly = Assembly(planes=[ground], friction=0.5)
    c, s = cos(angle), sin(angle)
    for level in (1, 2):
        z = (level - 0.5) * THICKNESS
        brick = Brick(f"b{level}", Box((LENGTH, WIDTH, THICKNESS)), 0.01)
        verdict = assembly.add(brick, Pose((z * s, 0.0, z * c), turn))
    assert (verdict.stability is Stability.STABLE) is stands
    if not stands:
        assert "slide" in verdict.reason


def test_statics_needs_no_engine_and_no_solver_until_it_asks_one() -> None:
    code = (
        "import sys; from stability.statics.assembly import Assembly; Assembly();"
        "sys.exit(any(name in sys.modules for name in ('pybullet', 'scipy', 'clarabel')))"
    )
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0


@pytest.mark.parametrize(("overhang", "stands"), [(0.499999, True), (0.500001, False)])
def test_a_table_carries_up_to_its_edge(overhang: float, stands: bool) -> None:
    table = Placed(Brick("table", Box((1.0, 1.0, 0.1)), 1.0), Pose((0.0, 0.0, -0.05)))
    assembly = Assembly(planes=(), tables=(table,))
    verdict = assembly.add(*_unpacked(plank("a", (0.5 + (overhang - 0.5) * LENGTH, 0.0))))
    assert (verdict.stability is Stability.STABLE) is stands
    assert assembly.rests_on("a") == ("table",)


def test_a_table_above_holds_nothing_up() -> None:
    # The plank hangs below the table, in touch with it.
    table = Placed(Brick("table", Box((1.0, 1.0, 0.1)), 1.0), Pose((0.0, 0.0, 0.05)))
    verdict = Assembly(planes=(), tables=(table,)).add(*_unpacked(plank("a", level=0)))
    assert (verdict.stability, verdict.moving) == (Stability.UNSTABLE, ("a",))


@pytest.mark.parametrize("change", ["remove", "move"])
def test_the_fall_of_one_structure_is_not_remembered_of_another(change: str) -> None:
    #   The plank that hovers apart falls first, so nothing is known yet of the stack that leans.
    leaning = [
        replace(placed, pose=replace(placed.pose, position_W=(x + (0.005 * number if number > 1 else 0.0), y, z)))
        for number, placed in enumerate(four_stack(6))
        for x, y, z in [placed.pose.position_W]
    ]
    alone = assembly_of(*leaning).verdict()
    assembly = assembly_of(*leaning, plank("hovering", (-5.0, 0.0), level=1000))
    assert assembly.verdict().moving == ("hovering",)
    if change == "remove":
        after = assembly.remove(["hovering"])
    else:
        after = assembly.move("hovering", plank("hovering", (-5.0, 0.0)).pose)
    assert (after.stability, after.moving) == (alone.stability, alone.moving)


def _unpacked(placed: Placed) -> tuple[Brick, Pose]:
    return placed.brick, placed.pose


def leaning_row(planks: int, slope: float = 70.0, friction: float = 0.5) -> Assembly:
    """Planks that lean on one another like books, the first on a wall."""
    theta = float(np.radians(slope))
    turn = (0.0, sin(-theta / 2), 0.0, cos(theta / 2))
    half_wide = 0.5 * (LENGTH * cos(theta) + THICKNESS * sin(theta))
    z = 0.5 * (LENGTH * sin(theta) + THICKNESS * cos(theta))
    wall = Plane("wall", (half_wide, 0.0, 0.0), (-1.0, 0.0, 0.0), friction)
    ground = Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction)
    assembly = Assembly(planes=[ground, wall], friction=friction)
    pitch = THICKNESS / sin(theta)
    brick = Brick("b", Box((LENGTH, WIDTH, THICKNESS)), 0.01)
    assembly.add_all([Placed(replace(brick, id=f"b{i:03}"), Pose((-i * pitch, 0.0, z), turn)) for i in range(planks)])
    return assembly


@pytest.mark.parametrize("planks", [1, 10, 40])
def test_a_long_row_of_leaning_planks_does_not_rest_on_self_stress(planks: int) -> None:
    assert leaning_row(planks).verdict().stability is Stability.STABLE


@pytest.mark.parametrize(
    ("names_smallest", "moving"), [(True, ["b004"]), (False, ["b000", "b001", "b002", "b003", "b004"])]
)
def test_of_what_falls_as_few_bricks_are_named_as_fall_alone_unless_nobody_asks(
    names_smallest: bool, moving: list[BodyId]
) -> None:
    #   The row slips apart as a whole, but its last plank would slip as well if all others were held.
    slippery = leaning_row(5, friction=0.1)
    row = list(slippery.bricks.values())
    slippery.remove(list(slippery.bricks))
    assert list(slippery.add_all(row, names_smallest=names_smallest).moving) == moving
    rest = slippery.remove(["b004"], names_smallest=names_smallest)
    assert list(rest.moving) == (["b003"] if names_smallest else moving[:-1])


def test_an_undecided_verdict_is_not_computed_again_after_a_distant_change(monkeypatch: pytest.MonkeyPatch) -> None:
    walls = [
        Plane("left", (-0.06, 0.0, 0.0), (1.0, 0.0, 0.0), 0.5),
        Plane("right", (0.06, 0.0, 0.0), (-1.0, 0.0, 0.0), 0.5),
    ]
    ground = Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)
    assembly = Assembly(planes=[ground, *walls])
    wedged = [plank(f"w{i}", (0.0, i * WIDTH), level=50) for i in range(3)]
    assert assembly.add_all(wedged).stability is Stability.UNDECIDED
    asked: list[BodyId] = []
    monkeypatch.setattr("stability.statics.prover.judge", lambda _structure, brick, *_: asked.append(brick))
    far = Brick("far", Box((0.02, 0.02, 0.02)), 0.01)
    verdict = assembly.add(far, Pose((0.0, -5.0, 0.01)))
    assert (verdict.stability, set(verdict.moving)) == (Stability.UNDECIDED, {"w0", "w1", "w2"})
    assert assembly.remove(["far"]).stability is Stability.UNDECIDED
    assert asked == []


@pytest.mark.parametrize("distance", [1e3, 1e6])
def test_far_from_the_origin_a_proof_is_as_good_as_the_coordinates(distance: float) -> None:
    assembly = Assembly()
    for level in range(1, 11):
        placed = plank(f"a{level}", (distance + 0.0108 * level, distance), level=level)
        assert assembly.add(placed.brick, placed.pose).stability is Stability.STABLE
    assert assembly.forces() is not None


@pytest.mark.parametrize(("below", "told"), [("a", "4 mm inside a"), ("ground", "4 mm inside ground")])
def test_the_reason_names_a_body_that_a_brick_is_too_deep_in(below: str, told: str) -> None:
    assembly = Assembly(overlap=inf)
    if below == "a":
        assembly.add_all([plank("a")])
    lowered = plank("b", level=2 if below == "a" else 1)
    x, y, z = lowered.pose.position_W
    verdict = assembly.add(lowered.brick, replace(lowered.pose, position_W=(x, y, z - THICKNESS / 2)))
    assert verdict.stability is Stability.UNSTABLE
    assert told in verdict.reason
