"""Bricks with studs look like toy bricks in pictures and replays."""

import numpy as np
import pytest

from stability.geometry.box import Box
from stability.model import Pose
from stackdsl.viewing.drawing import VIEWS, DrawingArea, Solid, faces_of, solids_at
from stackdsl.viewing.replay.page import payload_of
from stackdsl.viewing.run_view import RunView
from tests.stackdsl.viewing.views import views_of

LEGO = """
    scenario: lego
    brick: lego_2x4
    brick_types: {dry: {size: [32 mm, 16 mm, 9.6 mm], mass: 2 g}}
    build:
      - bricks: [{stud: [0, 0, 0], name: low}]
      - bricks:
          - {stud: [4, 0, 0], name: flat, brick: lego_tile_2x4}
          - {at: [88 mm, 8 mm, 4.8 mm], name: dry, brick: dry}
    expect: [{stands: all}]
"""


@pytest.fixture(scope="module")
def run() -> RunView:
    (view,) = views_of(LEGO)
    return view


def test_a_brick_has_a_stud_in_the_middle_of_each_cell_and_a_tile_has_none(run: RunView) -> None:
    solids = solids_at(run, 0.0)
    assert {name: len(solid.studs) for name, solid in solids.items()} == {"low": 8, "flat": 0, "dry": 0}
    middles = sorted(tuple(np.round(1000.0 * foot.mean(axis=0), 6)) for foot, _ in solids["low"].studs)
    assert middles == [(x, y, 9.6) for x in (4.0, 12.0, 20.0, 28.0) for y in (4.0, 12.0)]
    for foot, top in solids["low"].studs:
        assert np.linalg.norm(foot - foot.mean(axis=0), axis=1) == pytest.approx(0.0024)
        assert top - foot == pytest.approx(np.tile((0.0, 0.0, 0.0017), (len(foot), 1)), abs=1e-9)


def test_studs_are_seen_from_above_and_from_the_side(run: RunView) -> None:
    solids, paper = solids_at(run, 0.0), DrawingArea(np.zeros(2), 1000.0, 100.0, 100.0)
    for view, faces in (("three-quarter", 3 + 16), ("front", 1 + 8), ("plan", 1 + 16)):
        drawn = faces_of({"low": solids["low"]}, {"low": "#808080"}, VIEWS[view], paper)
        assert len(drawn) == faces


def test_studs_inside_of_another_brick_are_not_drawn(run: RunView) -> None:
    low = solids_at(run, 0.0)["low"]
    above = Solid.of(Box((0.016, 0.016, 0.0096)), Pose((0.008, 0.008, 0.0144)))  # on the left four studs
    paper = DrawingArea(np.zeros(2), 1000.0, 100.0, 100.0)
    for view, drawn in (("front", 1 + 4), ("plan", 1 + 8)):
        faces = faces_of({"low": low, "above": above}, {"low": "#808080", "above": "#808080"}, VIEWS[view], paper)
        assert sum(face.brick == "low" for face in faces) == drawn


def test_studs_are_in_the_shapes_of_a_replay(run: RunView) -> None:
    told = payload_of(run, hurried=True)
    heights = [max(z for _, _, z in shape["corners"]) for shape in told["shapes"]]
    of_brick = {
        name: heights[number] for name, number in zip(told["bricks"]["name"], told["bricks"]["shape"], strict=True)
    }
    assert of_brick == pytest.approx({"low": 0.0048 + 0.0017, "flat": 0.0016, "dry": 0.0048})
