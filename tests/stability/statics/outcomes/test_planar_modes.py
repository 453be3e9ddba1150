"""Random boxes on random edges of fixed planes, against an enumeration of all modes of contact in the plane."""

from collections.abc import Iterator
from math import cos, radians, sin, tan
from random import Random

import pytest

from stability import outcome
from stability.model import Plane
from stability.statics.assembly import Assembly
from stability.statics.facts import Stability
from stability.statics.margins.guarantee import guarantee
from tests.stability.statics.outcomes.leaning_scenes import aslant_between_walls, box, pile_on_a_slope, plane
from tests.stability.statics.outcomes.planar_modes import STICKS, starts


def on_planes(random: Random) -> Assembly | None:
    """A box turned at random whose corners touch one to three planes; None if a plane cuts it."""
    size, angle = (1.0, random.uniform(0.1, 1.0), random.uniform(0.02, 1.2)), random.uniform(-80.0, 80.0)
    turn = radians(angle)
    corners = [
        (x * cos(turn) + z * sin(turn), 1.0 - x * sin(turn) + z * cos(turn))
        for x in (-0.5, 0.5)
        for z in (-0.5 * size[2], 0.5 * size[2])
    ]
    planes: list[Plane] = []
    for number, (x, z) in enumerate(random.sample(corners, random.choice([1, 2, 2, 2, 3]))):
        found = plane(f"p{number}", random.uniform(-150.0, 150.0), random.choice([0.1, 0.3, 0.5, 0.8, 1.2, 2.5]), x, z)
        nx, _, nz = found.normal_W
        if sorted((cx - x) * nx + (cz - z) * nz for cx, cz in corners)[1] < 0.01:
            return None
        planes.append(found)
    made = Assembly(planes)
    made.add_all([box("a", size, 0.0, 1.0, angle)])
    return made


def that_need_friction(seed: int, count: int) -> Iterator[Assembly]:
    random = Random(seed)
    while count:
        made = on_planes(random)
        if made is None or made.verdict().stability is not Stability.STABLE:
            continue
        if guarantee(made.problem(), made.forces()) is None:
            count -= 1
            yield made


def agrees(made: Assembly) -> bool:
    """Whether a guarantee leaves no start in the plane, and a start in the plane leaves no guarantee; all decided."""
    found = outcome(made.problem(), made.forces())
    decided = found.guaranteed or found.start is not None
    return decided and not (found.guaranteed and any(starts(made.problem())))


def test_all_modes_of_a_slope_are_at_rest_below_the_friction_angle_alone() -> None:
    assert not list(starts(pile_on_a_slope(1, 20.0, 1.01 * tan(radians(20.0))).problem()))


def test_free_fall_between_walls_is_among_all_modes() -> None:
    modes = list(starts(aslant_between_walls(20.0, 0.6, 0.1).problem()))
    assert modes
    assert not any(STICKS in each for each in modes)


def test_random_boxes_on_random_planes_are_decided_as_all_modes_have_it() -> None:
    assert all(agrees(made) for made in that_need_friction(7, 12))


@pytest.mark.slow
def test_many_random_boxes_on_random_planes_are_decided_as_all_modes_have_it() -> None:
    assert all(agrees(made) for made in that_need_friction(8, 150))
