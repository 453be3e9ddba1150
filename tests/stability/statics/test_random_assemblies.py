"""A thousand random piles: no verdict is contradicted by the independent check, and every proof holds."""

from collections import Counter
from dataclasses import dataclass, replace
from functools import cache
from math import cos, inf, pi, sin

import numpy as np
import pytest

from stability.geometry.vectors import multiply, rotate
from stability.model import GROUND, Plane, Pose
from stability.problem import Placed, Stability, Tolerances, Verdict
from stability.statics.assembly import Assembly
from stability.statics.proof import check_forces, check_motion
from tests.stability.statics.independent import Answer, flat_touches, independent_verdict, verdict_of
from tests.stability.statics.published_model import published_model_says_stable
from tests.stability.statics.random_piles import FRICTION, SEED, random_pile

# What takes long is worked out once for all tests here, which so stay in one process.
pytestmark = pytest.mark.xdist_group("random piles")

PILES, CHUNKS = 1000, 10
QUICK = 1  # of the chunks is judged on every run, the others where there is time
in_each_chunk = pytest.mark.parametrize(
    "chunk", [pytest.param(chunk, marks=[] if chunk < QUICK else [pytest.mark.slow]) for chunk in range(CHUNKS)]
)
over_all_chunks = pytest.mark.parametrize("chunks", [QUICK, pytest.param(CHUNKS, marks=pytest.mark.slow)])
OPPOSITE: dict[Stability, Answer] = {Stability.STABLE: "unstable", Stability.UNSTABLE: "stable"}


@dataclass(frozen=True, slots=True)
class Judged:
    """A pile, all its planks set down together, and what is said of it."""

    pile: tuple[Placed, ...]
    assembly: Assembly
    verdict: Verdict
    checked: Answer | None  # by the independent check


@cache
def pile(number: int) -> tuple[Placed, ...]:
    """One of `random_piles`, of which most are not needed every time."""
    return random_pile(np.random.default_rng([SEED, number]), number)


@cache
def judged(chunk: int) -> list[Judged]:
    """A tenth of them; kept for all tests, since the independent check takes longest."""
    found = []
    for number in range(chunk, PILES, CHUNKS):
        assembly = Assembly(friction=FRICTION)
        verdict = assembly.add_all(pile(number))
        found.append(Judged(pile(number), assembly, verdict, independent_verdict(pile(number), FRICTION)))
    return found


@in_each_chunk
def test_no_verdict_is_contradicted_by_the_independent_check(chunk: int) -> None:
    contradicted = [each for each in judged(chunk) if each.checked == OPPOSITE.get(each.verdict.stability)]
    assert contradicted == []


@in_each_chunk
def test_forces_of_every_stable_pile_balance_by_plain_arithmetic(chunk: int) -> None:
    for each in judged(chunk):
        if each.verdict.stability is Stability.STABLE:
            forces = each.assembly.forces()
            assert forces is not None
            assert check_forces(each.assembly.problem(), forces, Tolerances()).holds


@in_each_chunk
def test_the_motion_of_every_unstable_pile_is_one_that_nothing_stops(chunk: int) -> None:
    for each in judged(chunk):
        if each.verdict.stability is Stability.UNSTABLE:
            motion = each.verdict.motion
            assert motion is not None
            assert check_motion(each.assembly.problem(), motion, Tolerances()).holds
            assert set(each.verdict.moving) == set(motion.velocity)


@in_each_chunk
def test_set_down_one_by_one_a_pile_that_stands_all_along_ends_with_the_same_verdict(chunk: int) -> None:
    for each in judged(chunk):
        assembly = Assembly(friction=FRICTION)
        verdicts = [assembly.add(placed.brick, placed.pose) for placed in each.pile]
        if all(verdict.stability is Stability.STABLE for verdict in verdicts[:-1]):
            assert verdicts[-1].stability is each.verdict.stability


@in_each_chunk
def test_what_is_left_when_the_moving_set_is_taken_away_comes_to_stand(chunk: int) -> None:
    for each in judged(chunk)[:40]:
        assembly, verdict = Assembly(friction=FRICTION), each.verdict
        assembly.add_all(each.pile)
        while verdict.stability is not Stability.STABLE:
            assert verdict.moving
            verdict = assembly.remove(verdict.moving)
        left = tuple(placed for placed in each.pile if placed.brick.id in assembly.bricks)
        assert independent_verdict(left, FRICTION) != "unstable"


@in_each_chunk
def test_after_planks_are_taken_away_the_verdict_is_that_of_the_rest_judged_afresh(chunk: int) -> None:
    for number, each in enumerate(judged(chunk)[:50]):
        generator = np.random.default_rng([11, chunk, number])
        assembly = Assembly(friction=FRICTION)
        assembly.add_all(each.pile)
        taken = [placed.brick.id for placed in each.pile if generator.random() < 0.3]
        left = [placed for placed in each.pile if placed.brick.id not in taken]
        afresh = Assembly(friction=FRICTION).add_all(left)
        assert assembly.remove(taken).stability is afresh.stability


@in_each_chunk
def test_after_a_plank_is_moved_the_verdict_is_that_of_the_new_pile_judged_afresh(chunk: int) -> None:
    for each in judged(chunk)[:50]:
        assembly = Assembly(friction=FRICTION, overlap=inf)  # it may be moved into another
        assembly.add_all(each.pile)
        first, last = each.pile[0], each.pile[-1]
        x, y, z = last.pose.position_W
        moved = replace(last, pose=replace(last.pose, position_W=(x + 0.02, y - 0.01, z)))
        afresh = Assembly(friction=FRICTION, overlap=inf).add_all([*each.pile[:-1], moved])
        assert assembly.move(last.brick.id, moved.pose).stability is afresh.stability
        assert assembly.move(last.brick.id, last.pose).stability is each.verdict.stability
        assert assembly.move(first.brick.id, first.pose).stability is each.verdict.stability


@in_each_chunk
def test_no_verdict_on_a_pile_on_a_slope_is_contradicted(chunk: int) -> None:
    # Slopes of up to 35 deg and frictions on either side of that: there most piles that stand need friction to do so.
    for number, each in enumerate(map(pile, range(chunk, 200 + chunk, CHUNKS))):
        generator = np.random.default_rng([5, chunk, number])
        friction, angle, bearing = (float(generator.uniform(0.0, most)) for most in (1.0, 0.6, 2.0 * pi))
        turn = (-sin(bearing) * sin(0.5 * angle), cos(bearing) * sin(0.5 * angle), 0.0, cos(0.5 * angle))
        touches = [
            replace(
                touch,
                points=tuple(rotate(turn, point) for point in touch.points),
                normal=rotate(turn, touch.normal),
                along=rotate(turn, touch.along),
            )
            for touch in flat_touches(each, friction)
        ]
        bricks = [
            Placed(placed.brick, Pose(rotate(turn, placed.pose.position_W), multiply(turn, placed.pose.orientation)))
            for placed in each
        ]
        ground = Plane(GROUND, (0.0, 0.0, 0.0), rotate(turn, (0.0, 0.0, 1.0)), friction)
        verdict = Assembly(planes=(ground,), friction=friction).add_all(bricks)
        checked = verdict_of({placed.brick.id: placed for placed in bricks}, touches)
        assert checked != OPPOSITE.get(verdict.stability), (chunk, number)
        assert verdict.stability is not Stability.UNDECIDED


@over_all_chunks
def test_few_are_undecided_and_both_verdicts_are_common(chunks: int) -> None:
    said = [each.verdict.stability for chunk in range(chunks) for each in judged(chunk)]
    assert said.count(Stability.UNDECIDED) < 0.01 * len(said)
    assert said.count(Stability.STABLE) > 0.3 * len(said)
    assert said.count(Stability.UNSTABLE) > 0.3 * len(said)


@over_all_chunks
def test_the_independent_check_can_fail_to_agree(chunks: int) -> None:
    # The check must be one that a wrong verdict would not survive: it is certain of nearly every pile.
    certain = [each.checked for chunk in range(chunks) for each in judged(chunk)]
    assert certain.count(None) < 0.01 * len(certain)
    assert {"stable", "unstable"} <= set(certain)


@over_all_chunks
def test_the_published_model_is_wrong_about_as_often_as_the_documentation_says(chunks: int) -> None:
    table = Counter(
        (published_model_says_stable(each.pile), each.verdict.stability)
        for chunk in range(chunks)
        for each in judged(chunk)
    )
    stable = table[True, Stability.STABLE] + table[False, Stability.STABLE]
    unstable = table[True, Stability.UNSTABLE] + table[False, Stability.UNSTABLE]
    assert 0.05 < table[False, Stability.STABLE] / stable < 0.40
    assert table[True, Stability.UNSTABLE] / unstable < 0.30
