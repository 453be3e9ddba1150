"""Which bricks are near: the same as asking every pair, but without asking."""

from collections.abc import Sequence
from math import cos, sin

from hypothesis import given
from hypothesis import strategies as st

from stability.contacts.bodies import AnySolid, solid
from stability.geometry.box import Box
from stability.geometry.box_distance import reach_between
from stability.geometry.spatial_grid import Neighbours
from stability.model import Brick, Pose, Quaternion, Vec3
from stability.problem import Placed

PLANK = (0.1176, 0.0234, 0.0078)


def brick(name: str, size: Vec3, position: Vec3, orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)) -> AnySolid:
    return solid(Placed(Brick(name, Box(size), 1.0), Pose(position, orientation)))


def filled(bricks: Sequence[AnySolid]) -> Neighbours[str]:
    neighbours: Neighbours[str] = Neighbours()
    for each in bricks:
        neighbours.add(each.id, each.low_W, each.high_W)
    return neighbours


def near(brick: AnySolid, neighbours: Neighbours[str]) -> list[str]:
    """Return the bodies that a body may touch, whether it is in the index or not."""
    reach = reach_between(brick.shortest)
    if brick.id in neighbours:
        return neighbours.neighbours(brick.id, reach)
    return neighbours.around(brick.low_W, brick.high_W, reach)


def near_by_asking_all(brick: AnySolid, others: Sequence[AnySolid]) -> list[str]:
    reach = reach_between(brick.shortest)
    return sorted(
        other.id
        for other in others
        if other.id != brick.id
        and all(
            a - reach <= d and c <= b + reach
            for a, b, c, d in zip(brick.low_W, brick.high_W, other.low_W, other.high_W, strict=True)
        )
    )


def test_a_plank_of_a_stack_has_the_ones_below_and_above_it_as_neighbours() -> None:
    stack = filled([brick(f"b{level}", PLANK, (0.0, 0.0, level * PLANK[2])) for level in range(50)])
    assert near(brick("b7", PLANK, (0.0, 0.0, 7 * PLANK[2])), stack) == ["b6", "b8"]
    assert near(brick("new", PLANK, (0.0, 0.0, 50 * PLANK[2])), stack) == ["b49"]


def test_a_removed_brick_is_no_neighbour() -> None:
    pair = filled([brick("a", PLANK, (0.0, 0.0, 0.0)), brick("b", PLANK, (0.0, 0.0, PLANK[2]))])
    pair.remove("a")
    assert near(brick("c", PLANK, (0.0, 0.0, 0.0)), pair) == ["b"]
    pair.remove("b")
    assert near(brick("c", PLANK, (0.0, 0.0, 0.0)), pair) == []


SIZE = st.sampled_from([PLANK, (0.1, 0.1, 0.1), (30.0, 40.0, 0.5), (1e-3, 1e-3, 2e-3), (0.02, 0.02, 3.0)])
PLACE = st.tuples(*[st.floats(-0.5, 0.5)] * 3)
TURN = st.floats(0.0, 3.0).map(lambda angle: (sin(angle) * 0.6, 0.0, sin(angle) * 0.8, cos(angle)))


@given(st.lists(st.tuples(SIZE, PLACE, TURN), min_size=1, max_size=25), st.sampled_from([0.0, 1e6]), st.data())
def test_bricks_of_all_sizes_find_each_other(
    parts: list[tuple[Vec3, Vec3, Quaternion]], far: float, data: st.DataObject
) -> None:
    bricks = [brick(f"b{i}", size, (x + far, y, z), turn) for i, (size, (x, y, z), turn) in enumerate(parts)]
    neighbours = filled(bricks)
    gone = data.draw(st.sets(st.sampled_from(bricks), max_size=len(bricks) - 1)) if len(bricks) > 1 else set()
    for each in gone:
        neighbours.remove(each.id)
    left = [each for each in bricks if each not in gone]
    for each in bricks:
        assert near(each, neighbours) == near_by_asking_all(each, left)


def test_a_slab_among_pebbles_takes_few_cells() -> None:
    # A million cells of a pebble's size would take a second and a gigabyte.
    pebbles = [brick(f"p{i}", (1e-3, 1e-3, 1e-3), (0.01 * i, 0.0, 5e-4)) for i in range(100)]
    neighbours = filled([*pebbles, brick("slab", (1e3, 1e3, 1.0), (0.0, 0.0, -0.5))])
    assert near(pebbles[3], neighbours) == ["slab"]
    assert len(near(brick("other", (1e3, 1e3, 1.0), (0.0, 0.0, 0.5)), neighbours)) == 101
