"""Who rests on whom, and which part of its load goes there."""

from math import isnan, radians

import pytest

from stability.statics.assembly import Assembly
from tests.stability.statics import closed_forms
from tests.stability.statics.test_assembly import counterweighted, four_stack, plank


def assembled(structure: closed_forms.Structure) -> Assembly:
    assembly = Assembly(planes=structure.planes, friction=structure.friction)
    assembly.add_all(structure.bricks)
    return assembly


def test_each_plank_of_a_four_stack_rests_half_on_either_of_two() -> None:
    assembly = Assembly()
    assembly.add_all(four_stack(4))
    graph = assembly.all_shares()
    assert graph["L1.0"] == {"ground": 1.0}
    for level in (2, 3, 4):
        assert graph[f"L{level}.1"] == pytest.approx({f"L{level - 1}.0": 0.5, f"L{level - 1}.1": 0.5})
        assert assembly.rests_on(f"L{level}.1") == (f"L{level - 1}.0", f"L{level - 1}.1")


def test_a_ladder_on_a_smooth_wall_gives_the_ground_all_its_weight_and_leans_on_the_wall() -> None:
    assembly = assembled(closed_forms.ladder(0.8))
    (name,) = assembly.bricks
    floor, wall = (plane.id for plane in assembly.planes)
    assert assembly.shares(name) == {floor: 1.0, wall: 0.0}
    assert assembly.rests_on(name) == tuple(sorted((floor, wall)))


def test_of_a_ladder_on_a_rough_wall_nobody_knows_how_much_the_wall_takes() -> None:
    assembly = assembled(closed_forms.ladder(0.8, floor=0.4, wall=0.3))
    (name,) = assembly.bricks
    assert all(isnan(share) for share in assembly.shares(name).values())
    assert len(assembly.rests_on(name)) == 2


def test_the_planks_of_an_inverted_v_rest_on_the_ground_and_on_each_other() -> None:
    assembly = assembled(closed_forms.inverted_v(0.8, theta=radians(60.0)))
    one, other = assembly.bricks
    assert set(assembly.rests_on(one)) == {"ground", other}
    assert set(assembly.rests_on(other)) == {"ground", one}


def test_a_counterweighted_brick_on_one_support_passes_on_its_whole_load() -> None:
    assembly = Assembly()
    assembly.add_all(counterweighted(weight=0.05))
    assert assembly.all_shares() == {"g": {"ground": 1.0}, "s": {"g": 1.0}, "p": {"s": 1.0}, "w": {"s": 1.0}}


def test_a_falling_brick_has_no_supports() -> None:
    assembly = Assembly()
    assembly.add_all([plank("a", level=3)])
    assert assembly.shares("a") == {}
    assert assembly.rests_on("a") == ()


def test_unknown_names_are_told() -> None:
    assembly = Assembly()
    for ask in (assembly.shares, assembly.rests_on, assembly.contacts, assembly.stage):
        with pytest.raises(LookupError, match="there is no brick 'z'"):
            ask("z")
