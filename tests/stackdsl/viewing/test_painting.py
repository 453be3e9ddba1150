"""Painter's order, checked point by point against rays from the viewer."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest

from stability.geometry.box import Box
from stability.geometry.round_solid import cylinder, sphere
from stability.geometry.rows import Array
from stability.model import Pose
from stackdsl.viewing.drawing import VIEWS, Face, Solid, View, brick_shapes, painters_order, solids_at
from tests.stackdsl.viewing.views import SLANT_TOWER, views_of

CARD_HOUSE = """
    scenario: house
    friction: 0.9
    build:
      - card_house: {levels: 3, angle: 70 deg}
    systems: [exact]
    expect: [{stands: all}]
"""


def depth_on_ray(solid: Solid, start: Array, view: View) -> float:
    """How near to the eye a ray along the direction of view meets a solid [m]; -inf if it misses."""
    nearest, farthest = np.inf, -np.inf
    for normal, face in zip(solid.normals, solid.faces, strict=True):
        facing, room = float(normal @ view.towards), float(normal @ (solid.corners[face[0]] - start))
        if abs(facing) < 1e-9:
            if room < 0.0:
                return -np.inf
        elif facing > 0.0:
            nearest = min(nearest, room / facing)
        else:
            farthest = max(farthest, room / facing)
    return nearest if nearest > farthest else -np.inf


def wrongly_covered(solids: Sequence[Solid], view: View, points: int = 300) -> int:
    """At how many random points on paper what is painted last is not what is nearest to the eye."""
    order = painters_order(solids, view)
    assert sorted(order) == list(range(len(solids)))
    place = {solid: turn for turn, solid in enumerate(order)}
    paper = np.concatenate([view.on_paper(solid.corners) for solid in solids])
    random, wrong = np.random.default_rng(3), 0
    for x, y in random.uniform(paper.min(axis=0), paper.max(axis=0), (points, 2)):
        start = x * view.right + y * view.up
        depths = [depth_on_ray(solid, start, view) for solid in solids]
        met = [number for number, depth in enumerate(depths) if depth > -np.inf]
        if met:
            last = max(met, key=place.__getitem__)
            wrong += depths[last] < max(depths) - 1e-6
    return wrong


@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@pytest.mark.parametrize("text", [SLANT_TOWER, CARD_HOUSE], ids=["fallen tower", "card house"])
def test_the_nearest_brick_is_painted_last(text: str, view: View) -> None:
    (run,) = views_of(text)
    assert wrongly_covered(list(solids_at(run, run.trace.cost.simulated_time).values()), view) == 0


def test_a_ring_of_planks_that_cover_each_other_is_painted_all_the_same() -> None:
    # Four planks around a square, each with one end on the next: from above no order is right.
    half, up = 0.04, 0.01
    tilt = np.arcsin(up / 0.12)
    ring = []
    for turn in range(4):
        angle = turn * np.pi / 2.0
        about_z = (0.0, 0.0, np.sin(angle / 2.0), np.cos(angle / 2.0))
        about_y = (0.0, np.sin(tilt / 2.0), 0.0, np.cos(tilt / 2.0))
        x, y = half * np.sin(angle), -half * np.cos(angle)
        ring.append(Solid.of(Box((0.12, 0.02, 0.004)), Pose((x, y, 0.02), _after(about_z, about_y))))
    assert sorted(painters_order(ring, VIEWS["plan"])) == [0, 1, 2, 3]


def test_a_wall_seen_from_the_front_is_painted_from_the_back() -> None:
    rows = [Solid.of(Box((0.12, 0.02, 0.008)), Pose((0.0, 0.03 * row, 0.004))) for row in (2, 0, 3, 1)]
    order = painters_order(rows, VIEWS["front"])
    assert all(rows[a].corners[:, 1].mean() > rows[b].corners[:, 1].mean() for a, b in pairwise(order))


def _after(q: tuple[float, ...], p: tuple[float, ...]) -> tuple[float, float, float, float]:
    v, w, u, s = np.array(q[:3]), q[3], np.array(p[:3]), p[3]
    x, y, z = w * u + s * v + np.cross(v, u)
    return (x, y, z, float(w * s - v @ u))


def test_the_sides_of_round_bodies_have_no_edges_but_those_of_their_ends() -> None:
    can, ball = (Solid.of(shape, Pose((0.0, 0.0, 0.0))) for shape in (cylinder(0.03, 0.1), sphere(0.03)))
    assert [sum(solid.is_curved) - len(solid.faces) for solid in (can, ball)] == [-2, 0]
    square = np.array(((0.0, 0.0), (9.0, 0.0), (9.0, 9.0)))
    side, end = Face("can", 0, square, "#111111", is_curved=True), Face("can", 0, square, "#222222")
    _, around, _ = brick_shapes([end, side], 1.0)
    outline, *faces = around.split("<path")[1:]
    assert "stroke" not in outline
    assert ["stroke=" in face for face in faces] == [True, False]
