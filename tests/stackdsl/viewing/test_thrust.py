"""The line of thrust of a proof, hinges at edges of joints, and arrows of loads, in pictures and replays."""

import pytest

from stackdsl.viewing.drawing import VIEWS, Overlay
from stackdsl.viewing.pictures import heading_at, panels_at, picture
from stackdsl.viewing.replay.page import payload_of
from stackdsl.viewing.thrust import JointForces, thrust_of
from tests.stackdsl.viewing.views import views_of

SQUARE = ((0.0, 0.0, 1.0), (2.0, 0.0, 1.0), (2.0, 2.0, 1.0), (0.0, 2.0, 1.0))
UP = (0.0, 0.0, 1.0)


def pressed(*shares: float, z: float = 1.0, upper: str = "b", lower: str = "a") -> JointForces:
    points = tuple((x, y, z) for x, y, _ in SQUARE)
    return JointForces(lower, upper, points, tuple((0.0, 0.0, share) for share in shares))


def test_the_thrust_goes_through_the_centre_of_the_pressures() -> None:
    joints = [pressed(1.0, 1.0, 1.0, 1.0, z=2.0, upper="c", lower="b"), pressed(1.0, 3.0, 3.0, 1.0)]
    (line,) = thrust_of(joints, {"b"}).lines
    assert (line.brick, line.begin_W, line.end_W) == ("b", (1.0, 1.0, 2.0), (1.5, 1.0, 1.0))
    assert line.force == 8.0
    assert thrust_of(joints, {"b"}).hinges == ()


@pytest.mark.parametrize(("shares", "hinge"), [((0, 1, 1, 0), (2.0, 1.0, 1.0)), ((0, 0, 1, 0), (2.0, 2.0, 1.0))])
def test_a_thrust_at_an_edge_or_a_corner_is_a_hinge(shares: tuple[float, ...], hinge: tuple[float, ...]) -> None:
    assert thrust_of([pressed(*shares)], {"b"}).hinges == (("b", hinge),)


def test_the_fixed_ground_has_no_line() -> None:
    joints = [pressed(1, 1, 1, 1, lower="ground"), pressed(1, 1, 1, 1, lower="ground", upper="c")]
    assert thrust_of(joints, {"b", "c"}).lines == ()


LOADED = """
    scenario: loaded
    brick: {size: [200 mm, 200 mm, 400 mm], density: 2000 kg/m3}
    build:
      - column: {levels: 2}
    loads:
      - {force: 20 N, towards: 0 deg, brick: L2.1, face: 180 deg}
    expect: [{stands: all}]
"""


def test_pictures_and_replays_have_loads_and_the_line_of_thrust() -> None:
    (run,) = views_of(LOADED)
    end = run.trace.cost.simulated_time
    plain = picture(run, heading_at(run, end), panels_at([VIEWS["front"]], end))
    drawn = picture(run, heading_at(run, end), panels_at([VIEWS["front"]], end, Overlay.THRUST))
    assert "20 N: loads" in drawn
    assert "line of thrust" in drawn
    assert "line of thrust" not in plain
    proof = payload_of(run)["proofs"][-1]
    ((brick, *numbers),) = proof["loads"]
    assert run.recording.bricks[brick].id == "L2.1"
    assert numbers == pytest.approx([-0.1, 0.0, 0.6, 20.0, 0.0, 0.0])
    # The thrust leaves L2.1 at x = F (0.6 - 0.4) / W, and the ground bears it at x = F 0.6 / (2 W), on both bricks.
    weight = 2000 * 0.2 * 0.2 * 0.4 * 9.81
    (line,) = proof["thrust"]
    assert line[1] == pytest.approx(20 * 0.2 / weight, rel=1e-5)
    assert line[4] == pytest.approx(20 * 0.6 / (2 * weight), rel=1e-5)
