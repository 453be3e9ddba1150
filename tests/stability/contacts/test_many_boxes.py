"""Contacts of many boxes at once are those of each pair, to the last digit."""

import random
from math import pi

import pytest

from stability.contacts.bodies import BoxSolid, box_solid
from stability.contacts.detection import contact_between
from stability.contacts.level_boxes import BoxArrays, contacts_of_pairs
from stability.geometry.vectors import about
from stability.model import Pose, Vec3
from stability.problem import Tolerances

STEP = 0.008  # [m]
GAPS = (0.0, 0.0, 0.0, 1e-13, 1e-8, 1e-5, -1e-5, 1e-4, -1e-4)  # [m]
TURNS = (0.0, 0.0, 0.0, 0.5 * pi, pi, -0.5 * pi, 0.3, 1e-6)  # [rad]


def drawn(draw: random.Random, count: int) -> list[BoxSolid]:
    """Boxes around one another on a grid, some turned, tilted or a little aside."""
    boxes = []
    for number in range(count):
        a, b, c = (draw.randint(1, 2) for _ in range(3))
        size: Vec3 = (STEP * a, STEP * b, STEP * c)
        x, y, z = (STEP * (draw.randint(-5, 5) + 0.5 * side) + draw.choice(GAPS) for side in (a, b, c))
        turn = draw.choice(TURNS)
        tilted = (0.0, 0.1, 0.0, (1.0 - 0.01) ** 0.5)
        boxes.append(
            box_solid(
                f"b{draw.random()}", size, Pose((x, y, z), tilted if number % 9 == 8 else about((0.0, 0.0, 1.0), turn))
            )
        )
    return boxes


@pytest.mark.parametrize("tolerances", [Tolerances(), Tolerances(within=0.0), Tolerances(within=2e-5)])
@pytest.mark.parametrize("seed", range(4))
def test_contacts_of_many_boxes_are_those_of_each_pair(seed: int, tolerances: Tolerances) -> None:
    boxes = drawn(random.Random(seed), 120)

    def friction(one: str, other: str) -> float:
        return 0.3 if max(one, other) > "b0.5" else 0.6

    arrays = BoxArrays.of(boxes)
    near = {*zip(*(each.tolist() for each in arrays.near(tolerances.gap)), strict=True)}
    pairs = [(i, j) for j in range(len(boxes)) for i in range(j)]
    expected = {
        (i, j): contact
        for i, j in pairs
        if (contact := contact_between(boxes[i], boxes[j], friction(boxes[i].id, boxes[j].id), tolerances))
    }
    assert len(expected) > 40
    assert near >= expected.keys()
    found = contacts_of_pairs(boxes, arrays, sorted(near), friction, tolerances)
    assert {sorted(near)[number]: contact for number, contact in found} == expected
