"""Bricks that are pulled: towers of Jenga blocks by closed form, and against linear programmes written apart."""

import random

import pytest

from benchmarks.equilibrium_programs import answer
from benchmarks.mending import FRICTION, GAP, jenga
from benchmarks.random_piles import upright
from stability.analysis.removal_order import LongestSearch, carrying, longest_order, single_pulls, soonest_fall
from stability.analysis.subset_search import Subsets
from stability.geometry.box import Box
from stability.model import Brick, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly


def tower(levels: int, without: tuple[str, ...] = (), gap: float = 0.0) -> Assembly:
    design = Assembly(friction=FRICTION)
    design.add_all([placed for placed in jenga(levels, gap) if placed.brick.id not in without])
    return design


def table() -> Assembly:
    """A beam across two posts."""
    design = Assembly()
    posts = [
        Placed(Brick(f"post{n}", Box((0.1, 0.1, 0.2)), 1.0), Pose((x, 0.0, 0.1))) for n, x in ((1, -0.4), (2, 0.4))
    ]
    design.add_all([*posts, Placed(Brick("beam", Box((1.0, 0.1, 0.1)), 5.0), Pose((0.0, 0.0, 0.25)))])
    return design


@pytest.mark.parametrize(
    ("levels", "without"),
    [
        (3, ()),
        (4, ("L1.1", "L2.3", "L3.2")),
        pytest.param(18, (), marks=pytest.mark.slow),
        pytest.param(12, tuple(f"L{level}.{1 + level % 2}" for level in range(1, 12)), marks=pytest.mark.slow),
    ],
)
def test_each_single_pull_is_as_a_linear_programme_has_it(levels: int, without: tuple[str, ...]) -> None:
    design = tower(levels, without, GAP if without else 0.0)
    pulls = list(single_pulls(design))
    assert len(pulls) == 3 * levels - len(without)
    for pull in pulls:
        rest = [upright(placed) for name, placed in design.bricks.items() if name != pull.brick]
        assert (pull.verdict.stability is Stability.STABLE) is answer(rest, FRICTION), pull.brick
    stands = {pull.verdict.stability for pull in pulls}
    assert stands == ({Stability.STABLE, Stability.UNSTABLE} if without else {Stability.STABLE})


def test_of_each_level_but_the_top_two_blocks_can_be_pulled_and_no_more() -> None:
    design = tower(4)
    parts = Subsets(design)
    found = longest_order(parts, parts.part_of(carrying(design)), most=1000)
    assert (len(found.order), found.at_most, found.proven) == (6, 6, True)
    rest = tower(4)  # each step once more, from scratch
    for name in found.order:
        rest.remove([name])
        cold = Assembly(friction=FRICTION)
        assert cold.add_all(rest.bricks.values()).stability is Stability.STABLE


def test_a_search_that_is_interrupted_keeps_its_longest_order_and_its_bound() -> None:
    parts = Subsets(tower(4))

    def press(asked: int) -> None:
        if asked >= 3:  # two blocks of level 3 are pulled by then, and the third holds the top
            raise KeyboardInterrupt

    search = LongestSearch(parts, parts.part_of(carrying(parts.design)), 1000, press)
    with pytest.raises(KeyboardInterrupt):
        search.run()
    assert (len(search.best.order), search.best.at_most, search.best.proven) == (2, 9, False)


def test_a_tower_falls_soonest_with_two_blocks_of_one_level_and_a_table_with_one_post() -> None:
    design = tower(4)
    parts = Subsets(design)
    soonest = soonest_fall(parts, parts.part_of(carrying(design)), most=1000)
    assert (soonest.at_least, len({name.split(".")[0] for name in soonest.order}), len(soonest.order)) == (2, 1, 2)
    posts = Subsets(table())
    assert soonest_fall(posts, posts.part_of(["post1", "post2"]), most=100).order in {("post1",), ("post2",)}
    longest = longest_order(posts, posts.part_of(["post1", "post2"]), most=100)
    assert (longest.order, longest.at_most) == ((), 0)


def test_pulls_distinguish_bricks_without_load_from_blocks_side_by_side() -> None:
    assert carrying(tower(2)) == ["L1.1", "L1.2", "L1.3"]


def test_a_fall_that_settles_another_part_is_what_a_cold_verdict_says() -> None:
    design = tower(4, gap=GAP)
    parts, draw = Subsets(design), random.Random(3)
    settled = 0
    for _ in range(60):
        part = parts.part_of(name for name in parts.names if draw.random() < 0.7)
        asked = parts.verdict_count
        said = parts.ask(part).stability
        if parts.verdict_count == asked:
            settled += 1
            cold = Assembly(friction=FRICTION)
            assert cold.add_all([design.bricks[name] for name in parts.names_of(part)]).stability is said
    assert settled > 3  # or nothing would have been seen


def test_a_copy_changes_by_itself() -> None:
    design = tower(3)
    copied = design.copied()
    copied.remove(["L1.1", "L1.2"])
    assert copied.verdict().stability is Stability.UNSTABLE
    assert (len(design.bricks), design.verdict().stability) == (9, Stability.STABLE)
    assert design.forces() is not None
