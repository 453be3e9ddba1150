"""The shown proofs are those of the structure at that time, and their forces carry its weight."""

from math import inf, isnan

import pytest

from tests.stackdsl.viewing.views import SLANT_TOWER, views_of

WEIGHT = 9.81  # [N/kg]
STANDS = """
    scenario: stack
    build:
      - four_stack: {levels: %d}
        every: 1 s
    systems: [%s]
    expect: [{stands: all}]
"""


def test_the_forces_of_the_ground_carry_all_that_stands_then() -> None:
    (run,) = views_of(SLANT_TOWER)
    masses = {brick.id: brick.mass for brick in run.recording.bricks}
    for proof in run.proofs.standing:
        ground = [contact for contact in proof.contacts if contact.lower == "ground"]
        upwards = sum(force[2] for contact in ground for force in contact.forces_W)
        assert upwards == pytest.approx(WEIGHT * sum(masses[name] for name in proof.bricks))
        for name, brick in proof.bricks.items():
            total = sum(brick.rests_on.values())  # no number where several could take it and nothing says which does
            assert isnan(total) or total == pytest.approx(1.0), name


def test_the_tower_is_shown_as_it_is_built_until_what_makes_it_fall_comes() -> None:
    (run,) = views_of(SLANT_TOWER)
    built = [proof for proof in run.proofs.standing if proof.end < inf]
    assert [(proof.begin, proof.end, len(proof.bricks)) for proof in built] == [(n, n + 1, n + 1) for n in range(13)]
    assert run.proofs.fall is not None
    assert run.proofs.fall.time == 13.0
    assert "L7.2" in run.proofs.fall.motion.velocity
    assert "L1.1" not in run.proofs.fall.motion.velocity  # what it turns over stays


@pytest.mark.parametrize("system", ["exact", "thesis"])
def test_what_stands_to_the_end_has_its_last_proof_to_the_end(system: str) -> None:
    (run,) = views_of(STANDS % (3, system))
    assert run.proofs.standing[-1].end == inf
    assert len(run.proofs.standing[-1].bricks) == 6
    assert run.proofs.fall is None


def test_of_many_bricks_only_the_whole_is_shown() -> None:
    (run,) = views_of(STANDS % (30, "exact"))
    assert [len(proof.bricks) for proof in run.proofs.standing] == [60]


def test_of_what_falls_at_once_there_is_the_motion_alone() -> None:
    (run,) = views_of(
        """
    scenario: leans
    build:
      - bricks: [{name: alone, at: [0 mm, 0 mm, 58.584 mm], rotate: [0 deg, 80 deg, 0 deg]}]
    systems: [exact]
    expect: [{collapses: any}]
"""
    )
    assert [proof for proof in run.proofs.standing if "alone" in proof.bricks and proof.begin == 0.0] == []
    assert run.proofs.fall is not None
    assert set(run.proofs.fall.motion.velocity) == {"alone"}
