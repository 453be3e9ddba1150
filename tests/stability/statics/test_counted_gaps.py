"""A verdict tells which gaps it counts on: bricks that stand only across gaps are stable as touching within so much."""

import pickle

import pytest

from stability.geometry.box import Box
from stability.model import Brick, Pose
from stability.problem import Placed, Stability, Tolerances
from stability.statics.assembly import LEVEL_GROUND, Assembly

THICKNESS = 8e-3  # of a beam [m]; its reach is 0.16 mm
HEIGHT = 24e-3  # of the piers [m]
AT_ENDS = (-0.05, 0.05)  # of the beam [m]


def beam_on_piers(places: tuple[float, ...], gaps: tuple[float, ...], size: float = 1.0) -> list[Placed]:
    """A beam along x on piers whose tops are so much below it [m]."""
    piers = [
        Placed(
            Brick(f"pier {number}", Box((size * 0.008, size * 0.02, size * (HEIGHT - gap))), 0.01),
            Pose((size * x, 0.0, 0.5 * size * (HEIGHT - gap))),
        )
        for number, (x, gap) in enumerate(zip(places, gaps, strict=True))
    ]
    beam = Brick("beam", Box((size * 0.12, size * 0.02, size * THICKNESS)), 0.01)
    return [*piers, Placed(beam, Pose((0.0, 0.0, size * (HEIGHT + 0.5 * THICKNESS))))]


@pytest.mark.parametrize("gap", [1e-6, 5e-5, 1.5e-4])
def test_a_beam_across_a_pier_that_is_too_low_is_stable_as_touching_within_the_gap(gap: float) -> None:
    bricks = beam_on_piers(AT_ENDS, (0.0, gap))
    verdict = Assembly().add_all(bricks)
    assert verdict.stability is Stability.STABLE
    assert verdict.touching_within == pytest.approx(gap, rel=0.01)
    assert verdict.touching_within >= gap
    again = Assembly(tolerances=Tolerances(within=verdict.touching_within))
    assert again.add_all(bricks).stability is Stability.STABLE
    for less in (0.0, 0.98 * gap):
        assert Assembly(tolerances=Tolerances(within=less)).add_all(bricks).stability is Stability.UNSTABLE


def test_of_two_gaps_the_wider_one_counts_if_both_are_needed() -> None:
    assert Assembly().add_all(beam_on_piers(AT_ENDS, (2e-5, 8e-5))).touching_within == pytest.approx(8e-5, rel=0.01)


def test_a_pier_that_does_not_reach_the_beam_is_not_needed_where_others_carry_it() -> None:
    bricks = beam_on_piers((*AT_ENDS, 0.0), (0.0, 0.0, 1e-4))
    assert Assembly().add_all(bricks).touching_within == 0.0


def test_of_three_piers_the_least_gaps_that_are_enough_count() -> None:
    bricks = beam_on_piers((-0.05, 0.05, 0.02), (0.0, 1e-4, 3e-5))
    assert Assembly().add_all(bricks).touching_within == pytest.approx(3e-5, rel=0.01)


@pytest.mark.parametrize("gap", [0.0, 1e-9, -1e-9, -1e-5])
def test_contacts_within_rounding_or_penetrating_are_no_counted_gaps(gap: float) -> None:
    verdict = Assembly().add_all(beam_on_piers(AT_ENDS, (0.0, gap)))
    assert (verdict.stability, verdict.touching_within) == (Stability.STABLE, 0.0)


@pytest.mark.parametrize("size", [0.1, 100.0])
def test_gaps_scale_with_all_else(size: float) -> None:
    verdict = Assembly().add_all(beam_on_piers(AT_ENDS, (0.0, 5e-5), size))
    assert verdict.touching_within == pytest.approx(size * 5e-5, rel=0.01)


def test_a_gap_that_has_gone_again_is_not_counted() -> None:
    beam_on_low_pier = beam_on_piers(AT_ENDS, (0.0, 5e-5))
    assembly = Assembly()
    before = assembly.state()
    assert assembly.add_all(beam_on_low_pier).touching_within > 0.0
    assert assembly.copied().verdict().touching_within > 0.0
    assembly.restore(before)
    assert assembly.add_all(beam_on_piers(AT_ENDS, (0.0, 0.0))).touching_within == 0.0
    assembly.remove(["beam", "pier 1"])
    assembly.add_all(beam_on_low_pier[1:2])
    assert assembly.add_all(beam_on_low_pier[2:]).touching_within == pytest.approx(5e-5, rel=0.01)
    assert assembly.remove(["beam"]).touching_within == 0.0


def test_counted_gaps_include_a_box_above_the_ground() -> None:
    ground = (LEVEL_GROUND,)
    raised = Placed(Brick("box", Box((0.1, 0.1, 0.1)), 1.0), Pose((0.0, 0.0, 0.05 + 1e-3)))
    verdict = Assembly(ground).add_all([raised])
    assert verdict.stability is Stability.STABLE
    assert verdict.touching_within == pytest.approx(1e-3, rel=0.01)


def test_the_answer_survives_being_sent_to_another_process() -> None:
    verdict = Assembly().add_all(beam_on_piers(AT_ENDS, (0.0, 5e-5)))
    unasked = pickle.loads(pickle.dumps(verdict))
    assert unasked.touching_within == verdict.touching_within
    assert pickle.loads(pickle.dumps(verdict)).touching_within == verdict.touching_within
