"""Division of solids with flat faces into convex parts: volume, moments and refusals."""

from itertools import pairwise, product

import numpy as np
import pytest

from stability.geometry.compound import Compound, parts_of
from stability.geometry.convex_parts import bent_prism, body_of_mesh, convex_parts
from stability.geometry.convex_solid import ConvexSolid, NotASolidError
from stability.geometry.vectors import about, rotate
from stability.graph import components
from stability.model import Vec3

ELL = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]
Cell = tuple[int, int, int]


def surface(cells: set[Cell]) -> tuple[list[Vec3], list[list[int]]]:
    """The surface of unit cubes, with its faces counter-clockwise seen from outside."""
    places: dict[Vec3, int] = {}
    loops = []
    for cell in sorted(cells):
        for axis, side in product(range(3), (0, 1)):
            beside = list(cell)
            beside[axis] += 2 * side - 1
            if tuple(beside) in cells:
                continue
            u, v = (axis + 1) % 3, (axis + 2) % 3
            loop = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = [float(part) for part in cell]
                corner[axis] += side
                corner[u] += a
                corner[v] += b
                loop.append(places.setdefault((corner[0], corner[1], corner[2]), len(places)))
            loops.append(loop if side else loop[::-1])
    return list(places), loops


def random_cells(seed: int) -> set[Cell]:
    """Cubes joined by faces, of which no two touch along an edge or at a corner only."""
    rng = np.random.default_rng(seed)
    while True:
        cells = {cell for cell in product(range(3), range(3), range(2)) if rng.random() < 0.6}

        def beside(cell: str, cells: set[Cell] = cells) -> list[str]:
            x, y, z = map(int, cell.split())
            steps = product(range(3), (-1, 1))
            near = [tuple(part + (way if k == axis else 0) for k, part in enumerate((x, y, z))) for axis, way in steps]
            return [f"{a} {b} {c}" for a, b, c in near if (a, b, c) in cells]

        if not cells or len(components({f"{x} {y} {z}" for x, y, z in cells}, beside)) > 1:
            continue
        try:
            body_of_mesh(*surface(cells))
        except NotASolidError as error:
            if "common edge" in error.message:
                continue
            raise
        return cells


@pytest.mark.parametrize("seed", range(12))
def test_a_solid_of_cubes_keeps_its_volume_centre_and_moments_in_parts(seed: int) -> None:
    cells = random_cells(seed)
    turn = about((0.6, 0.0, 0.8), 0.3 * seed)
    points, loops = surface(cells)
    made = body_of_mesh([rotate(turn, point) for point in points], loops)
    centres = np.array([[part + 0.5 for part in cell] for cell in sorted(cells)])
    middle = centres.mean(axis=0)
    arms = centres - middle
    tensor = sum(np.eye(3) * (arm @ arm + 1.0 / 6.0) - np.outer(arm, arm) for arm in arms) / len(cells)
    assert made.shape.volume == pytest.approx(len(cells), rel=1e-9)
    assert made.centre_of_mass == pytest.approx(rotate(turn, tuple(middle.tolist())), abs=1e-9)
    assert sorted(made.shape.moments(1.0)) == pytest.approx(np.linalg.eigvalsh(tensor), rel=1e-9)
    assert len(parts_of(made.shape)) <= len(cells)


def test_an_outline_of_an_ell_gives_two_boxes() -> None:
    made = bent_prism(ELL, 2.0)
    assert isinstance(made.shape, Compound)
    assert len(made.shape.parts) == 2
    assert made.shape.volume == pytest.approx(10.0, rel=1e-12)
    assert bent_prism(ELL[::-1], 2.0).shape.volume == pytest.approx(10.0, rel=1e-12)


def test_a_convex_outline_stays_one_solid() -> None:
    assert isinstance(bent_prism([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)], 1.0).shape, ConvexSolid)


def test_a_pipe_of_eight_sides_has_eight_parts_or_fewer() -> None:
    outer = [(np.cos(0.25 * np.pi * k), np.sin(0.25 * np.pi * k)) for k in range(8)]
    points = [(r * x, r * y, z) for z in (0.0, 1.0) for r in (1.0, 0.8) for x, y in outer]
    loops: list[list[int]] = []
    for k in range(8):
        n = (k + 1) % 8
        loops += [[k, n, 16 + n, 16 + k], [8 + n, 8 + k, 24 + k, 24 + n]]  # outside and inside
        loops += [[16 + k, 16 + n, 24 + n, 24 + k], [n, k, 8 + k, 8 + n]]  # above and below
    made = body_of_mesh(points, loops)
    area = 8.0 * 0.5 * np.sin(0.25 * np.pi)
    assert made.shape.volume == pytest.approx(area * (1.0 - 0.8**2), rel=1e-9)
    assert len(parts_of(made.shape)) <= 8


@pytest.mark.parametrize(
    ("outline", "cause"),
    [
        ([(0.0, 0.0), (2.0, 0.0), (0.0, 2.0), (2.0, 2.0), (1.0, 3.0)], "crosses itself between corners 2 and 5"),
        ([(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 0.0), (0.0, 4.0)], "crosses itself"),
    ],
)
def test_outlines_that_cross_themselves_are_refused(outline: list[tuple[float, float]], cause: str) -> None:
    with pytest.raises(NotASolidError) as refused:
        bent_prism(outline, 1.0)
    assert cause in refused.value.message


def test_surfaces_that_cross_each_other_are_refused() -> None:
    points, loops = surface({(0, 0, 0), (1, 0, 0), (0, 1, 0)})
    crossing = [(x, y, 2.0 - z) if (x, y) == (0.0, 0.0) else (x, y, z) for x, y, z in points]
    with pytest.raises(NotASolidError):
        body_of_mesh(crossing, loops)


def test_a_curved_solid_of_too_many_faces_is_refused_with_a_remedy() -> None:
    grid = 46
    points = [(float(x), float(y), float((x * x + 3 * y * y) % 7)) for x in range(grid) for y in range(grid)]
    loops = [[x * grid + y, (x + 1) * grid + y, x * grid + y + 1] for x in range(grid - 1) for y in range(grid - 1)]
    with pytest.raises(NotASolidError, match="2025 triangles; the maximum"):
        convex_parts(points, loops)


@pytest.mark.parametrize("seed", range(12))
def test_a_block_with_warped_faces_has_the_volume_that_its_triangles_enclose(seed: int) -> None:
    random = np.random.default_rng(seed)
    corners = [(float(x), float(y), float(z)) for x, y, z in product((0, 1), repeat=3)]
    shift = [10.0 ** random.uniform(-4.0, -1.0) * random.uniform(-1.0, 1.0, 3) for _ in corners]
    points = [(x + a, y + b, z + c) for (x, y, z), (a, b, c) in zip(corners, shift, strict=True)]
    loops = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    enclosed = (
        sum(np.linalg.det([points[a], points[b], points[c]]) for a, *rest in loops for b, c in pairwise(rest)) / 6.0
    )
    assert body_of_mesh(points, loops).shape.volume == pytest.approx(enclosed, rel=1e-4)


@pytest.mark.parametrize("start", [0, 4, 5])
def test_a_warped_face_that_is_dented_is_divided_from_the_corner_that_sees_all_of_it(start: int) -> None:
    # The corner opposite to the bend sees all of an ell, too: the loops reach the bend first.
    random = np.random.default_rng(start)
    points = [(x, y, z + random.uniform(-0.05, 0.05)) for z in (0.0, 1.0) for x, y in ELL]
    sides = [[k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6] for k in range(6)]
    seen = [
        [6 + (3 + k) % 6 for k in range(6)],
        [(3 - k) % 6 for k in range(6)],
    ]  # from corner 3, where the ell is bent
    enclosed = sum(
        np.linalg.det([points[a], points[b], points[c]]) for a, *rest in seen + sides for b, c in pairwise(rest)
    )
    made = body_of_mesh(points, [*(face[start:] + face[:start] for face in seen), *sides])
    assert made.shape.volume == pytest.approx(enclosed / 6.0, rel=1e-4)
