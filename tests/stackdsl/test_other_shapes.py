"""Shapes other than boxes are watched, judged and observed by their own geometry."""

import pytest

from stability.model import AT_REST, GROUND, BodyState, Brick, ConvexShape, Plane, Pose, Vec3
from stackdsl.compiler.fit import TimedShape, fits
from stackdsl.language.claims.height import Height
from stackdsl.results import observations
from stackdsl.simulation.brick_tracks import TrackedBrick
from stackdsl.simulation.measurements import kinetic_energy
from stackdsl.timeline import Placement
from stackdsl.trace import BrickState, BrickTrack, Cost, Event, EventKind, Trace
from tests.stability.geometry.polyhedra import LOWER_HALF, SIZE, TETRAHEDRON
from tests.stackdsl.goldens.towers import taken

LENGTH, WIDTH, THICKNESS = SIZE
MASS = 0.006
ON_GROUND = Pose((0.0, 0.0, THICKNESS / 3.0))  # a wedge with its flat side down
WEDGE = Brick("wedge", LOWER_HALF, MASS)


def standing(brick: Brick, pose: Pose) -> Trace:
    track = BrickTrack(brick, 1, BrickState.FROZEN, pose, pose, pose, shift=0.001, tilt=0.0)
    placed = Event(0.0, EventKind.PLACED, (brick.id,))
    return Trace((placed,), {brick.id: track}, (), None, Cost(0.1, 1.0, 0, 1), {})


def watched(brick: Brick, shift: float) -> TrackedBrick:
    one = TrackedBrick(Placement(0.0, brick, 1, ON_GROUND), 0, rest=ON_GROUND, last=ON_GROUND)
    x, y, z = ON_GROUND.position_W
    one.see(1.0, BodyState(Pose((x + shift, y, z))))
    return one


@pytest.mark.parametrize("shape", [LOWER_HALF, TETRAHEDRON], ids=["wedge", "tetrahedron"])
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_brick_has_left_its_place_by_half_of_its_least_thickness(shape: ConvexShape, share: float) -> None:
    brick = Brick("any", shape, MASS)
    one = watched(brick, share * 0.5 * brick.shape.least_thickness)
    assert one.left_its_place is (share > 1.0)


def test_a_wedge_is_as_thin_as_across_its_slope() -> None:
    #   The height of the right-angled triangle above its longest side.
    assert LOWER_HALF.least_thickness == pytest.approx(LENGTH * THICKNESS / (LENGTH**2 + THICKNESS**2) ** 0.5)


def test_what_is_seen_of_a_wedge_is_as_high_as_its_thick_end() -> None:
    seen = observations(standing(WEDGE, ON_GROUND))
    assert seen["height"] == pytest.approx(1000.0 * THICKNESS)
    assert seen["drift"] == pytest.approx(1.0)


def test_a_claim_of_a_height_is_judged_by_the_highest_corner() -> None:
    claim = Height.model_validate({"is": f"{1000.0 * THICKNESS} mm ± 0.001 mm"})
    assert claim.judge(standing(WEDGE, ON_GROUND)).passed


def test_a_wedge_that_turns_about_its_width_has_the_energy_of_its_own_moment() -> None:
    spin: Vec3 = (0.0, 5.0, 0.0)
    moment = MASS * (LENGTH**2 + THICKNESS**2) / 18.0  # of a right-angled triangle about its centre
    found = kinetic_energy(WEDGE, BodyState(ON_GROUND, AT_REST, spin))
    assert found == pytest.approx(0.5 * moment * 25.0)


def test_a_golden_and_a_build_take_a_wedge() -> None:
    assert "wedge" in str(taken(standing(WEDGE, ON_GROUND)))
    (fit,) = fits([TimedShape(0.0, LOWER_HALF, ON_GROUND)], [Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)])
    assert fit.on_planes == (0,)
