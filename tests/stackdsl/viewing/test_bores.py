"""Pipes are drawn with their bore: in replays and glTF as a closed surface, in pictures as a hole."""

from math import pi, sin

import numpy as np
import pytest

from stability.geometry.round_solid import SIDES, RoundSolid, cylinder, pipe
from stability.geometry.vectors import about
from stability.model import Pose
from stackdsl.viewing.bores import bore_rims, surface_of_pipe
from stackdsl.viewing.drawing import VIEWS, DrawingArea, Solid, faces_of
from stackdsl.viewing.replay.page import payload_of
from tests.stackdsl.viewing.views import views_of

PIPE = pipe(0.05, 0.01, 0.2, (0.0, 0.0, 0.03))


def triangles(solid: RoundSolid) -> np.ndarray:
    corners, faces = surface_of_pipe(solid)
    points = np.array(corners)
    return np.array([points[list(each)] for a, b, c, d in faces for each in ((a, b, c), (a, c, d))])


def test_the_surface_of_a_pipe_encloses_the_volume_between_two_prisms() -> None:
    a, b, c = triangles(PIPE).transpose(1, 0, 2)
    area = 0.5 * SIDES * sin(2.0 * pi / SIDES)  # of a polygon inside the unit circle
    assert np.einsum("ni,ni->", a, np.cross(b, c)) / 6.0 == pytest.approx(area * (0.05**2 - 0.04**2) * 0.2)
    assert 0.5 * np.cross(b - a, c - a).sum(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)


def test_a_bore_has_a_rim_at_both_ends_and_a_solid_cylinder_has_none() -> None:
    low, high = (np.array(rim) for rim in bore_rims(PIPE))
    assert np.hypot(low[:, 0], low[:, 1]) == pytest.approx(np.full(SIDES, 0.04))
    assert (low[0, 2], high[0, 2]) == pytest.approx((-0.13, 0.07))
    assert bore_rims(cylinder(0.05, 0.2)) == ()


def test_a_replay_has_the_bore_of_a_pipe() -> None:
    text = """
        scenario: one
        brick: {pipe: {diameter: 60 mm, wall: 10 mm, height: 100 mm}, mass: 1 kg}
        build: [bricks: [on: ground]]
        expect: [verdict: stable]
    """
    (shape,) = payload_of(views_of(text)[0])["shapes"]
    radii = {round(float(np.hypot(x, y)), 9) for x, y, _ in shape["corners"]}
    assert radii == {0.02, 0.03}
    assert len(shape["faces"]) == len(shape["curved"]) == 4 * SIDES


@pytest.mark.parametrize(("view", "turned", "seen"), [("plan", False, 1), ("front", False, 0), ("front", True, 1)])
def test_a_picture_shows_the_hole_of_an_end_that_looks_at_the_viewer(view: str, turned: bool, seen: int) -> None:
    pose = Pose((0.0, 0.0, 0.0), about((1.0, 0.0, 0.0), 0.5 * pi if turned else 0.0))
    paper = DrawingArea(np.zeros(2), 1000.0, 100.0, 100.0)
    drawn = [
        faces_of({"it": Solid.of(shape, pose)}, {"it": "#808080"}, VIEWS[view], paper)
        for shape in (PIPE, cylinder(0.05, 0.2, (0.0, 0.0, 0.03)))
    ]
    assert len(drawn[0]) - len(drawn[1]) == seen
    if seen:
        hole = drawn[0][-1]
        assert hole.area == pytest.approx(0.5 * SIDES * sin(2.0 * pi / SIDES) * 40.0**2)
        assert hole.fill < min(face.fill for face in drawn[1])  # darker than any face
