"""Joined bricks that are placed together have the contacts and the verdict of bricks that are placed one by one."""

import random

import pytest

from benchmarks.joined import KINDS
from benchmarks.joined import assembly_of as any_assembly
from benchmarks.joined import drawn as drawn_any
from benchmarks.studded import LEGO_STRENGTH, assembly_of, drawn
from stability.problem import Placed, by_place
from stability.statics.assembly import Assembly
from stability.statics.structure import Structure


def placed(assembly: Assembly, bricks: list[Placed], together: bool) -> Structure:
    site = assembly.planes, assembly.tables, assembly.friction, assembly.gravity, assembly.tolerances, assembly.joints
    structure = Structure(*site)
    coming = sorted(bricks, key=by_place)
    if together:
        assert structure.put_together(coming)
    else:
        for each in coming:
            structure.put(each)
    return structure


def assert_alike(assembly: Assembly, bricks: list[Placed]) -> None:
    one, other = (placed(assembly, bricks, together) for together in (True, False))
    assert list(one.bricks) == list(other.bricks)
    for name in one.bricks:
        assert list(one.touching[name].items()) == list(other.touching[name].items())
        assert one.supports[name] == other.supports[name]
        assert one.carried[name] == other.carried[name]
        assert one.cores[name].pieces == other.cores[name].pieces
        assert one.weights[name] == other.weights[name]
    assert one.joined == other.joined
    assert one.across_gaps == other.across_gaps


@pytest.mark.parametrize("seed", range(4))
def test_studded_bricks_placed_together_touch_as_one_by_one(seed: int) -> None:
    draw = random.Random(seed)
    assert_alike(*assembly_of(drawn(draw, draw.randint(20, 60)), LEGO_STRENGTH))


@pytest.mark.parametrize("seed", range(8))
def test_joined_bricks_placed_together_touch_as_one_by_one(seed: int) -> None:
    draw = random.Random(seed)
    assert_alike(*any_assembly(drawn_any(draw, KINDS[seed % len(KINDS)], draw.randint(4, 10))))
