"""Initial motion: closed forms of bodies that start to turn about an edge."""

from math import hypot

import pytest

from stability.dynamics.onset import as_it_begins
from stability.geometry.box import Box
from stability.geometry.vectors import cross, norm, scale, subtract
from stability.model import BodyId, Brick, Pose, Vec3
from stability.problem import Motion, Placed, Stability, Verdict
from stability.statics.assembly import Assembly
from stability.statics.proof import check_motion

LENGTH, WIDTH, THICKNESS = 0.12, 0.024, 0.008  # of a plank [m]
SIZE: Vec3 = (LENGTH, WIDTH, THICKNESS)


def stacked(*x: float, size: Vec3 = SIZE) -> list[Placed]:
    """Planks along x, named from the ground, one on another."""
    heights = (THICKNESS * (0.5 + number) for number in range(len(x)))
    return [
        Placed(Brick(f"p{n}", Box(size), 0.012), Pose((at, 0.0, z)))
        for n, (at, z) in enumerate(zip(x, heights, strict=True), start=1)
    ]


def begun(bricks: list[Placed]) -> tuple[Assembly, Verdict]:
    assembly = Assembly()
    first = assembly.add_all(bricks)
    assert first.stability is Stability.UNSTABLE
    found = as_it_begins(assembly, first)
    assert found.motion is not None
    assert check_motion(assembly.problem(), found.motion, assembly._structure.tolerances).holds
    return assembly, found


def turn_of(motion: Motion, bricks: dict[BodyId, Placed], edge_W: Vec3) -> float:
    """The one angular speed of these bricks about an edge along y; each must move so."""
    spin = next(iter(motion.velocity.values()))[1]
    for name, (velocity, turning) in motion.velocity.items():
        expected = cross(spin, subtract(bricks[name].pose.position_W, edge_W))
        assert norm(subtract(velocity, expected)) <= 1e-6 * norm(velocity)
        assert norm(subtract(turning, spin)) <= 1e-6 * norm(spin)
    return spin[1]


def test_a_plank_starts_to_tip_with_the_brick_that_tips_over_it() -> None:
    #              |---p4---|      p3 and p4 tip over the end of p2, for 99 mm > 40 mm + L/2 - but p2 to p4 have their
    #        |---p3---|            centre at 79 mm, far beyond the end of p1 at L/2, and tip with more vigour
    #    |---p2---|
    # |---p1---|
    bricks = stacked(0.0, 0.04, 0.074, 0.128)
    _, found = begun(bricks)
    assert found.moving == ("p2", "p3", "p4")
    assert found.motion is not None
    by_name = {placed.brick.id: placed for placed in bricks}
    assert turn_of(found.motion, by_name, (LENGTH / 2.0, 0.0, THICKNESS)) > 0.0
    assert found.reason == "p2 to p4 (3 bricks) tip over p1"


def test_the_smallest_falling_part_is_smaller_than_the_moving_one() -> None:
    assembly = Assembly()
    first = assembly.add_all(stacked(0.0, 0.04, 0.074, 0.128))
    assert first.moving == ("p3", "p4")


def test_a_column_begins_to_turn_as_one_about_the_edge_of_its_lowest_plank() -> None:
    bricks = stacked(*(0.011 * number for number in range(12)))  # (N + 1) d / 2 = 66 mm > L / 2
    _, found = begun(bricks)
    assert found.moving == tuple(sorted(f"p{n}" for n in range(2, 13)))
    assert found.motion is not None
    turn_of(found.motion, {placed.brick.id: placed for placed in bricks}, (LENGTH / 2.0, 0.0, THICKNESS))


@pytest.mark.parametrize("reach", [0.03, 0.05, 0.09, 0.095])
def test_a_crumb_on_a_plank_that_tips_falls_behind_where_the_plank_is_faster_than_free_fall(reach: float) -> None:
    # A plank with its centre c beyond the edge begins to turn with g c / (c^2 + (L^2 + t^2) / 12 + t^2 / 4), in which
    # the crumb has no part; at a distance r from the edge it falls with r times as much, the crumb with no more than g.
    c = 0.04
    lever = c / (c * c + (LENGTH * LENGTH + THICKNESS * THICKNESS) / 12.0 + THICKNESS * THICKNESS / 4.0)
    base, tipping = stacked(0.0, LENGTH / 2.0 + c)
    side = 0.002
    crumb = Placed(
        Brick("crumb", Box((side, side, side)), 1e-5), Pose((LENGTH / 2.0 + reach, 0.0, 2.0 * THICKNESS + side / 2.0))
    )
    _, found = begun([base, tipping, crumb])
    assert found.motion is not None
    (_, (_, spin, _)), (velocity, _) = found.motion.velocity["p2"], found.motion.velocity["crumb"]
    falls = -velocity[2] / spin  # [m] relative to the turn of the plank
    assert falls == pytest.approx(min(reach, 1.0 / lever), rel=5e-3)  # the crumb weighs a thousandth
    if reach > 1.0 / lever:
        assert hypot(velocity[0], velocity[1]) < 1e-3 * abs(velocity[2])


def test_a_standing_structure_has_no_onset_of_motion() -> None:
    assembly = Assembly()
    verdict = assembly.add_all(stacked(0.0, 0.0))
    assert as_it_begins(assembly, verdict) is verdict


def test_the_onset_without_contacts_is_a_free_fall() -> None:
    assembly = Assembly()
    first = assembly.add_all([*stacked(0.0), Placed(Brick("loose", Box(SIZE), 0.012), Pose((1.0, 0.0, 0.5)))])
    found = as_it_begins(assembly, first)
    assert found.moving == ("loose",)
    assert found.motion is not None
    velocity, spin = found.motion.velocity["loose"]
    assert scale(1.0 / norm(velocity), velocity) == pytest.approx((0.0, 0.0, -1.0))
    assert norm(spin) < 1e-9
