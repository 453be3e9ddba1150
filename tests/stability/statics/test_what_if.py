"""What would come of it, and back to where it was: nothing is left of what was only tried."""

from math import inf

import numpy as np
import pytest

from stability.contact_law import Friction
from stability.geometry.box import Box
from stability.geometry.solid_making import prism
from stability.model import Brick, Plane, Pose
from stability.problem import Placed, Stability, Verdict
from stability.statics.arrays import bricks_in_poses, bricks_of, forces_of, pose_of
from stability.statics.assembly import LEVEL_GROUND, Assembly
from tests.stability.statics.random_piles import FRICTION, random_pile

PLANK = (0.12, 0.024, 0.008)


def plank(name: str, x: float = 0.0, level: int = 1, y: float = 0.0) -> Placed:
    return Placed(Brick(name, Box(PLANK), 0.0115), Pose((x, y, (level - 0.5) * PLANK[2])))


def known(assembly: Assembly) -> object:
    """All that can be told of an assembly, to the bit."""
    return (
        list(assembly.bricks.items()),
        assembly.verdict(),
        assembly.all_contacts(),
        [(name, assembly.stage(name), assembly.contacts(name), assembly.rests_on(name)) for name in assembly.bricks],
        assembly.forces() if assembly.verdict().stability is Stability.STABLE else None,
        {name: sorted(assembly.around(name, 0.05)) for name in assembly.bricks},
    )


def built(placed: list[Placed]) -> Assembly:
    """Set down one by one, and stopped before what falls."""
    assembly = Assembly(friction=FRICTION)
    for each in placed:
        if assembly.would(each.brick, each.pose).stability is Stability.STABLE:
            assembly.add(each.brick, each.pose)
    return assembly


@pytest.mark.parametrize("number", range(12))
def test_a_hypothetical_verdict_is_the_later_verdict_and_changes_no_state(number: int) -> None:
    pile = random_pile(np.random.default_rng([8, number]), number)
    asked, unasked = Assembly(friction=FRICTION), Assembly(friction=FRICTION)
    for each in pile:
        before = known(asked)
        would = asked.would(each.brick, each.pose)
        assert known(asked) == before
        assert would == asked.add(each.brick, each.pose) == unasked.add(each.brick, each.pose)
        assert known(asked) == known(unasked)


@pytest.mark.parametrize("number", range(12))
def test_restoring_a_state_undoes_a_removal(number: int) -> None:
    generator = np.random.default_rng([9, number])
    assembly = built(list(random_pile(generator, number)))
    untouched = built(list(random_pile(np.random.default_rng([9, number]), number)))
    before, state = known(assembly), assembly.state()
    for _ in range(3):
        names = [name for name in assembly.bricks if generator.random() < 0.4]
        would = assembly.would_without(names)
        assert assembly.remove(names) == would
        assert assembly.bricks.keys().isdisjoint(names)
        assembly.restore(state)
        assert known(assembly) == before
    # And whatever comes next comes as if nothing had been: proofs are made from the same numbers in the same order.
    for name in list(assembly.bricks)[:2]:
        assert assembly.remove([name]) == untouched.remove([name])
        assert known(assembly) == known(untouched)


def test_many_would_be_judged_together_as_they_are_set_down_together() -> None:
    assembly = Assembly()
    assembly.add_all([plank("base")])
    pair = [plank("left", -0.05, level=2), plank("right", 0.1, level=2)]
    would = assembly.would_all(pair)
    assert (would.stability, would.moving) == (Stability.UNSTABLE, ("right",))
    assert list(assembly.bricks) == ["base"]
    assert assembly.add_all(pair) == would


def test_a_state_may_be_restored_over_and_over_and_states_do_not_disturb_each_other() -> None:
    assembly = Assembly()
    empty = assembly.state()
    assembly.add_all([plank("a")])
    one = assembly.state()
    assembly.add_all([plank("b", level=2)])
    two = known(assembly)
    both = assembly.state()
    for state, names in ((one, ["a"]), (both, ["a", "b"]), (empty, []), (both, ["a", "b"]), (one, ["a"])):
        assembly.restore(state)
        assert list(assembly.bricks) == names
    assembly.add_all([plank("b", level=2)])
    assert known(assembly) == two


def test_the_state_of_another_assembly_is_refused() -> None:
    with pytest.raises(ValueError, match="another assembly"):
        Assembly().restore(Assembly().state())
    with pytest.raises(TypeError, match="expected an AssemblyState"):
        Assembly().restore("yesterday")  # type: ignore[arg-type]


def test_an_invalid_hypothetical_change_leaves_the_assembly_unchanged() -> None:
    assembly = Assembly()
    assembly.add_all([plank("a")])
    before = known(assembly)
    for placed in (plank("a", level=2), plank("b"), plank("c", x=float("nan"))):
        with pytest.raises(ValueError, match=r"the name 'a'|inside 'a'|position"):
            assembly.would(placed.brick, placed.pose)
        assert known(assembly) == before
    with pytest.raises(LookupError):
        assembly.would_without(["nobody"])
    assert known(assembly) == before


# --- overlaps ---------------------------------------------------------------------------------------------------------


def test_two_bricks_in_one_place_are_no_assembly() -> None:
    assembly = Assembly()
    with pytest.raises(ValueError, match="brick 'b' is 8 mm inside 'a'"):
        assembly.add_all([plank("a"), plank("b")])
    assert not assembly.bricks
    assembly.add_all([plank("a")])
    with pytest.raises(ValueError, match="brick 'b' is 8 mm inside 'a'"):
        assembly.add_all([plank("b")])
    assert list(assembly.bricks) == ["a"]


@pytest.mark.parametrize(("depth", "fits"), [(0.0, True), (0.99e-4, True), (1.01e-4, False), (3e-3, False)])
def test_a_tenth_of_a_millimetre_is_forgiven_in_bricks_and_in_the_ground(depth: float, fits: bool) -> None:
    low = plank("low")
    for lowered in (Pose((0.0, 0.0, 0.004 - depth)), Pose((0.0, 0.0, 0.012 - depth))):
        assembly = Assembly()
        if lowered.position_W[2] > 0.008:
            assembly.add(low.brick, low.pose)
        if fits:
            assembly.add(plank("b").brick, lowered)
        else:
            with pytest.raises(ValueError, match=r"inside '(low|ground)'"):
                assembly.add(plank("b").brick, lowered)


def test_how_much_is_forgiven_is_said_and_never_more_than_still_touches() -> None:
    carton = Brick("carton", Box((0.4, 0.3, 0.2)), 5.0)
    for overlap, depth, fits in (
        (2e-3, 1.9e-3, True),
        (2e-3, 2.1e-3, False),
        (0.1, 3.9e-3, True),
        (0.1, 4.1e-3, False),
    ):
        assembly = Assembly(overlap=overlap)
        if fits:
            assembly.add(carton, Pose((0.0, 0.0, 0.1 - depth)))
        else:
            with pytest.raises(ValueError, match="inside 'ground'"):
                assembly.add(carton, Pose((0.0, 0.0, 0.1 - depth)))
    assembly = Assembly(overlap=0.1)
    assembly.add(carton, Pose((0.0, 0.0, 0.1)))
    with pytest.raises(ValueError, match="brick 'plank' is 1 mm inside 'carton'"):  # 2 % of a plank are 0.16 mm
        assembly.add(Brick("plank", Box(PLANK), 0.1), Pose((0.0, 0.0, 0.2 + 0.5 * PLANK[2] - 1e-3)))
    Assembly(overlap=inf).add(carton, Pose((0.0, 0.0, -1.0)))
    with pytest.raises(ValueError, match="the overlap is -1"):
        Assembly(overlap=-1.0)


def test_a_brick_is_moved_within_its_own_place_and_not_into_another() -> None:
    assembly = Assembly()
    assembly.add_all([plank("a"), plank("b", y=0.03)])
    assert assembly.move("b", plank("b", x=0.01, y=0.03).pose).stability is Stability.STABLE
    with pytest.raises(ValueError, match="brick 'b' is 4 mm inside 'a'"):
        assembly.move("b", plank("b", y=0.02).pose)
    assert assembly.bricks["b"].pose.position_W[0] == 0.01


def test_wedges_and_tables_are_bodies_like_others() -> None:
    roof = prism([(0.0, 0.0), (0.12, 0.0), (0.0, 0.06)], depth=0.04)
    x, _, z = roof.centre_of_mass
    table = Placed(Brick("table", Box((0.2, 0.2, 0.1)), 1.0), Pose((0.0, 0.0, 0.05)))
    assembly = Assembly((), tables=[table])
    assert assembly.add(Brick("roof", roof.shape, 0.1), Pose((x - 0.06, 0.0, 0.1 + z))).stability is Stability.STABLE
    with pytest.raises(ValueError, match=r"brick 'ball' is .* inside 'roof'"):
        assembly.add(Brick("ball", Box((0.01, 0.01, 0.01)), 0.1), Pose((-0.05, 0.0, 0.12)))
    with pytest.raises(ValueError, match="inside 'table'"):
        assembly.add(Brick("ball", Box((0.01, 0.01, 0.01)), 0.1), Pose((0.09, 0.09, 0.09)))


# --- arrays -----------------------------------------------------------------------------------------------------------


def test_arrays_in_are_bricks_and_bricks_are_arrays_again() -> None:
    half = 0.5**0.5
    positions = np.array([[0.0, 0.0, 0.004], [0.0, 0.0, 0.012]])
    orientations = np.array([[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, half, half]])
    assembly = Assembly()
    verdict = assembly.add_all(bricks_in_poses(["a", "b"], PLANK, 0.0115, positions, orientations))
    assert verdict.stability is Stability.STABLE
    found = bricks_of(assembly)
    assert found.names == ("a", "b")
    np.testing.assert_array_equal(found.positions, positions)
    np.testing.assert_array_equal(found.orientations, orientations)
    np.testing.assert_array_equal(found.masses, [0.0115, 0.0115])
    np.testing.assert_allclose(found.bounds[1], [[-0.012, -0.06, 0.008], [0.012, 0.06, 0.016]], atol=1e-15)


def test_the_forces_of_the_proof_carry_all_weights() -> None:
    assembly = Assembly()
    assembly.add_all(bricks_in_poses(["a", "b"], PLANK, [1.0, 2.0], [[0.0, 0.0, 0.004], [0.01, 0.0, 0.012]]))
    found = forces_of(assembly)
    assert found is not None
    on_ground = found.forces[[name == "ground" for name in found.lower]].sum(axis=0)
    np.testing.assert_allclose(on_ground, [0.0, 0.0, 3.0 * 9.81], atol=1e-9)
    assert found.points.shape == found.forces.shape == (len(found.upper), 3)


def test_a_quaternion_has_its_real_part_last() -> None:
    half = 0.5**0.5
    upright = pose_of(np.array([0.0, 0.0, 0.06]), np.array([0.0, half, 0.0, half]))  # a quarter turn about y
    assembly = Assembly()
    assembly.add(Brick("a", Box(PLANK), 1.0), upright)
    assert bricks_of(assembly).bounds[0, 1, 2] == pytest.approx(PLANK[0])


def test_no_bricks_are_arrays_as_well() -> None:
    found = bricks_of(Assembly())
    assert (found.positions.shape, found.orientations.shape, found.bounds.shape) == ((0, 3), (0, 4), (0, 2, 3))
    assert bricks_in_poses([], PLANK, 1.0, np.zeros((0, 3))) == []


@pytest.mark.parametrize(
    ("positions", "words"),
    [
        ([[0.0, 0.0]], r"positions have the array shape \(1, 2\); expected \(2, 3\)"),
        (np.zeros((3, 3)), r"positions have the array shape \(3, 3\)"),
        ([["a", 0, 0], [0, 0, 0]], "positions must be numbers"),
        ([[0.0, 0.0, float("nan")], [0.0, 0.0, 0.0]], "finite"),
    ],
)
def test_arrays_of_another_shape_are_told(positions: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        bricks_in_poses(["a", "b"], PLANK, 1.0, positions)  # type: ignore[arg-type]


def test_a_packer_asks_before_it_sets_down_on_a_smooth_sheet() -> None:
    slope = Plane("ground", (0.0, 0.0, 0.0), (0.6, 0.0, 0.8), 0.9)  # of 37 deg: its tangent is 0.75
    pose = pose_of([0.006, 0.0, 0.008], [0.0, (0.1) ** 0.5, 0.0, (0.9) ** 0.5])
    said: list[Verdict] = [
        Assembly((slope,), Friction(0.9, own={"sheet": own})).would(Brick("sheet", Box((0.1, 0.1, 0.02)), 1.0), pose)
        for own in (0.76, 0.74)
    ]
    assert [each.stability for each in said] == [Stability.STABLE, Stability.UNSTABLE]
    assert LEVEL_GROUND.friction == 0.5
