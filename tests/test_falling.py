"""How falls begin and where they land, against closed forms."""

from math import pi, radians, sin, sqrt

import pytest

from stability.model import Pose, Vec3
from stability.statics.facts import Motion
from stability.vectors import times
from stackdsl.judging.falling import along_screw, lands, pivots
from stackdsl.language.claims import Lands, Pivots
from stackdsl.playing.runner import play
from stackdsl.playing.systems import SYSTEMS
from stackdsl.trace import Cost, Onset, Trace
from tests.scenes import timeline_of

ASKED = "expect: [{pivots: {within: 5 deg}}, {lands: {reach: < 1 m}}]"


def test_a_quarter_turn_ends_half_of_it_off_the_tangent_and_a_chord_away() -> None:
    radius = 0.3
    #   Turning about the z-axis through (0, 0), from (0.3, 0) to (0, 0.3).
    got = along_screw((0.0, 2.0 * radius, 0.0), (0.0, 0.0, 2.0), lasts=0.25 * pi)
    assert got == pytest.approx((-radius, radius, 0.0))
    assert sum(part * part for part in got) == pytest.approx(2.0 * radius * radius)


def test_along_a_screw_the_axis_is_followed_and_without_a_turn_a_line() -> None:
    assert along_screw((0.0, 0.3, 0.1), (0.0, 0.0, 1.0), lasts=2.0 * pi) == pytest.approx((0.0, 0.0, 0.2 * pi))
    assert along_screw((1.0, 2.0, 3.0), (0.0, 0.0, 0.0), lasts=0.5) == (0.5, 1.0, 1.5)


def turned_about_y(angle: float, centre: Vec3) -> Pose:
    return Pose(centre, (0.0, sin(0.5 * angle), 0.0, sqrt(1.0 - sin(0.5 * angle) ** 2)))


def seen(first: Vec3, second: Vec3) -> Trace:
    """Two bricks that are proven to turn about the y-axis, at 0.1 m and 0.2 m above it, and got so far by 5 deg."""
    motion = Motion({"a": ((0.1, 0.0, 0.0), (0.0, 1.0, 0.0)), "b": ((0.2, 0.0, 0.0), (0.0, 1.0, 0.0))})
    poses = {
        name: (Pose((0.0, 0.0, high)), turned_about_y(radians(5.0), (there[0], there[1], high + there[2])))
        for name, high, there in (("a", 0.1, first), ("b", 0.2, second))
    }
    return Trace((), {}, (), None, Cost(0.0, 0.0, 0, 0), {}, onset=Onset(motion, poses, ("stump",)))


CHORD = 2.0 * sin(radians(2.5))  # of a turn of 5 deg, per radius; it points 2.5 deg below the tangent


def test_a_rigid_turn_is_the_proven_motion_though_its_chord_is_not_the_tangent() -> None:
    claim = Pivots.model_validate({"about": "stump", "within": "0.001 deg", "proportions": "0.1 %"})
    tilted = (CHORD * sin(radians(87.5)), 0.0, -CHORD * sin(radians(2.5)))
    assert pivots(claim, seen(times(0.1, tilted), times(0.2, tilted))).passed


@pytest.mark.parametrize(
    ("claim", "first", "passed", "margin", "measured"),
    [
        # along the tangent, and so half of the turn off
        ({"within": "2 deg"}, 0.1, False, -0.5, "within 2.5 deg"),
        ({"within": "3 deg"}, 0.1, True, 0.5, "within 2.5 deg"),
        # the lower one stays behind by half of its way, a quarter of that of the upper one
        ({"proportions": "10 %"}, 0.05, False, -15.0, "proportions within 25 %"),
        ({"proportions": "30 %"}, 0.05, True, 5.0, "proportions within 25 %"),
        ({"about": "L9.9"}, 0.1, False, -1.0, "about stump"),
    ],
)
def test_what_is_off_is_told_in_degrees_and_in_parts_of_the_largest(
    claim: dict[str, str], first: float, passed: bool, margin: float, measured: str
) -> None:
    found = pivots(Pivots.model_validate(claim), seen((first * CHORD, 0.0, 0.0), (0.2 * CHORD, 0.0, 0.0)))
    assert (found.passed, found.measured) == (passed, measured)
    assert found.margin == pytest.approx(margin)


def test_a_system_that_proves_nothing_names_no_motion() -> None:
    found = pivots(Pivots.model_validate({"within": "5 deg"}), Trace((), {}, (), None, Cost(0.0, 0.0, 0, 0), {}))
    assert (found.passed, found.measured) == (False, "it names no motion")


#    /     A plank on its end leans by 5 deg, so its centre is 58.8 mm sin 5 deg - 3.9 mm cos 5 deg = 1.24 mm beyond the
#   /      edge that it stands on. Flat on the ground its centre is 58.8 mm beyond it, if the edge stays where it is.
UPRIGHT = "- bricks: [{name: plank, at: [0 mm, 0 mm, 58.916 mm], rotate: [0 deg, -85 deg, %s deg]}]"


@pytest.mark.parametrize("bearing", [0, 120])
def test_a_plank_tips_about_the_edge_it_stands_on_and_lands_half_a_length_away(bearing: int) -> None:
    trace = play(timeline_of(UPRIGHT % bearing, f"friction: 2\n{ASKED}"), SYSTEMS["exact"])
    assert trace.onset is not None
    assert trace.onset.about == ("ground",)
    assert pivots(Pivots.model_validate({"within": "1 deg", "about": "ground"}), trace).passed
    claim = Lands.model_validate({"reach": "57.6 mm ± 3 mm", "bearing": f"{bearing} deg", "within": "2 deg"})
    found = lands(claim, trace)
    assert found.passed, found
    assert not lands(Lands.model_validate({"bearing": f"{bearing + 20} deg"}), trace).passed
