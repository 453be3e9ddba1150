"""Convex solids against closed forms: volume, centre of mass and moments; and rejected input."""

from collections.abc import Sequence
from itertools import product
from math import cos, pi, sin

import pytest

from stability.geometry.box import Box, OffCentreBox
from stability.geometry.convex_solid import ConvexSolid, NotASolidError
from stability.geometry.placed_shape import in_place, inertia_times, scaled
from stability.geometry.solid_making import MOST_FACES, inset_corners, prism, solid_of_corners, solid_of_mesh
from stability.geometry.vectors import rotate, subtract
from stability.model import IDENTITY, Brick, Pose, Vec3

CUBE: Sequence[Vec3] = [(float(x), float(y), float(z)) for x, y, z in product((0, 1), repeat=3)]
CUBE_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CORNER: Sequence[Vec3] = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]  # cut off a cube
TRIANGLE = [(0.0, 0.0), (3.0, 0.0), (0.0, 6.0)]


def sphere(count: int) -> list[Vec3]:
    """Points on a unit sphere, evenly spread (Fibonacci)."""
    angle = pi * (3.0 - 5.0**0.5)
    heights = [1.0 - (2.0 * n + 1.0) / count for n in range(count)]
    return [
        ((1.0 - z * z) ** 0.5 * cos(n * angle), (1.0 - z * z) ** 0.5 * sin(n * angle), z) for n, z in enumerate(heights)
    ]


def moments_of(shape: ConvexSolid | OffCentreBox | Box) -> list[float]:
    return sorted(shape.moments(1.0))


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (50.0, -20.0, 7.0)])
def test_a_cube_by_its_corners_is_a_cube_wherever_they_are_written(shift: Vec3) -> None:
    made = solid_of_corners([(x + shift[0], y + shift[1], z + shift[2]) for x, y, z in CUBE])
    assert made.centre_of_mass == pytest.approx([0.5 + part for part in shift])
    assert made.shape.volume == pytest.approx(1.0, rel=1e-12)
    assert moments_of(made.shape) == pytest.approx([1.0 / 6.0] * 3)
    assert (len(made.shape.corners), len(made.shape.edges), len(made.shape.faces)) == (8, 12, 6)
    assert (made.shape.least_thickness, made.shape.length) == pytest.approx((1.0, 1.0))


def test_a_corner_cut_off_a_cube_has_a_sixth_of_its_volume_a_quarter_of_it_from_the_faces() -> None:
    made = solid_of_corners(CORNER)
    assert made.shape.volume == pytest.approx(1.0 / 6.0)
    assert made.centre_of_mass == pytest.approx((0.25, 0.25, 0.25))
    # About the axis through the cut-off corner 3/80 of twice the sum of squares less the product of inertia -1/80.
    assert moments_of(made.shape) == pytest.approx([1.0 / 16.0, 1.0 / 16.0, 1.0 / 10.0])
    about = inertia_times(Brick("corner", made.shape, 1.0), IDENTITY, (1.0, 0.0, 0.0))
    assert about == pytest.approx((3.0 / 40.0, 1.0 / 80.0, 1.0 / 80.0))


def test_a_wedge_has_its_centre_a_third_of_the_way_up_and_along() -> None:
    made = prism(TRIANGLE, 2.0)
    assert made.centre_of_mass == pytest.approx((1.0, 0.0, 2.0))
    assert made.shape.volume == pytest.approx(18.0)
    # Of a right triangle: b^2/18, h^2/18 and -bh/36 about its centre; and d^2/12 along the depth.
    along_x, along_y, along_z = 9.0 / 18.0, 4.0 / 12.0, 36.0 / 18.0
    turned = inertia_times(Brick("wedge", made.shape, 1.0), IDENTITY, (1.0, 0.0, 0.0))
    assert turned == pytest.approx((along_y + along_z, 0.0, 3.0 * 6.0 / 36.0))
    turned = inertia_times(Brick("wedge", made.shape, 1.0), IDENTITY, (0.0, 1.0, 0.0))
    assert turned[1] == pytest.approx(along_x + along_z)


def test_the_outline_of_a_prism_runs_either_way_round_and_may_have_corners_amid_its_sides() -> None:
    made, other = prism(TRIANGLE, 2.0), prism([(0.0, 0.0), (0.0, 3.0), (0.0, 6.0), (3.0, 0.0)], 2.0)
    assert set(made.shape.corners) == {tuple(round(part, 12) for part in corner) for corner in other.shape.corners}
    assert len(other.shape.faces) == 5


def test_a_solid_is_the_same_by_its_corners_and_by_its_faces() -> None:
    assert solid_of_mesh(CUBE, CUBE_FACES).shape == solid_of_corners(CUBE).shape


def test_the_mesh_of_a_cube_in_many_triangles_is_a_cube_of_six_faces() -> None:
    count = 10
    points = [(x / count, y / count, z / count) for x, y, z in product(range(count + 1), repeat=3)]
    surface = [point for point in points if {0.0, 1.0} & set(point)]
    shape = solid_of_corners(surface).shape
    assert (len(shape.corners), len(shape.faces)) == (8, 6)


def test_a_centre_of_mass_that_is_said_is_where_the_origin_is_and_leaves_the_moments() -> None:
    made = solid_of_corners(CUBE, (0.25, 0.5, 0.5))
    assert made.shape.support((-1.0, 0.0, 0.0))[0] == pytest.approx(-0.25)
    assert made.shape.bounding_radius == pytest.approx((0.75**2 + 0.5) ** 0.5)
    assert moments_of(made.shape) == pytest.approx([1.0 / 6.0] * 3)


def test_a_box_that_is_packed_on_one_side_is_the_solid_with_its_corners() -> None:
    carton, centre = OffCentreBox((0.4, 0.3, 0.2), (0.05, -0.02, 0.01)), (0.05, -0.02, 0.01)
    solid = solid_of_corners(Box((0.4, 0.3, 0.2)).corners, centre).shape
    assert [pytest.approx(corner) for corner in carton.corners] == list(solid.corners)
    assert carton.bounding_radius == pytest.approx(solid.bounding_radius)
    assert moments_of(carton) == pytest.approx(moments_of(solid))
    for direction in ((1.0, 0.0, 0.0), (-0.6, 0.8, 0.0), (0.0, -1.0, 0.5)):
        assert carton.reach(direction) == pytest.approx(solid.reach(direction))


@pytest.mark.parametrize("shape", [OffCentreBox((0.4, 0.3, 0.2), (0.1, 0.0, 0.0)), solid_of_corners(CORNER).shape])
def test_larger_solids_have_all_in_proportion(shape: ConvexSolid | OffCentreBox) -> None:
    large = scaled(shape, 10.0)
    assert large.volume == pytest.approx(1000.0 * shape.volume)
    assert large.least_thickness == pytest.approx(10.0 * shape.least_thickness)
    assert large.bounding_radius == pytest.approx(10.0 * shape.bounding_radius)
    assert large.moments(1.0) == pytest.approx([100.0 * moment for moment in shape.moments(1.0)])


@pytest.mark.parametrize("shape", [OffCentreBox((0.4, 0.3, 0.2), (0.1, 0.0, 0.0)), solid_of_corners(CORNER).shape])
def test_rounding_reduces_the_depth_of_a_solid_across_every_face(shape: ConvexSolid | OffCentreBox) -> None:
    inner = inset_corners(shape, 0.004)
    for face in shape.faces:
        reach = max(sum(a * b for a, b in zip(corner, face.normal, strict=True)) for corner in inner)
        assert reach == pytest.approx(shape.reach(face.normal) - 0.004)


def test_a_solid_in_its_place_reaches_as_far_as_its_corners() -> None:
    shape = solid_of_corners(CORNER).shape
    turn = (0.0, 0.0, sin(0.2), cos(0.2))
    body = in_place(shape, Pose((1.0, 2.0, 3.0), turn))
    highest = max(rotate(turn, corner)[0] for corner in shape.corners)
    assert body.high_W[0] == pytest.approx(1.0 + highest)


# --- rejected input ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("outline", "cause"),
    [
        ([(0.0, 0.0), (1.0, 0.0), (0.2, 0.2), (0.0, 1.0)], "turns inwards at corner 3"),
        ([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)], "no area"),
        ([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)], "crosses itself"),
        ([(cos(4.0 * pi * n / 5.0), sin(4.0 * pi * n / 5.0)) for n in range(5)], "crosses itself"),
        ([(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0)], "two corners of the outline coincide"),
    ],
)
def test_an_outline_that_is_not_convex_is_refused_with_the_corner(
    outline: list[tuple[float, float]], cause: str
) -> None:
    with pytest.raises(NotASolidError, match=cause):
        prism(outline, 0.1)


def test_points_in_one_plane_are_no_solid() -> None:
    with pytest.raises(NotASolidError, match="in one plane"):
        solid_of_corners([(0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (0.0, 1.0, 1.0), (1.0, 1.0, 2.0)])


def test_a_point_inside_of_the_others_is_refused_by_number() -> None:
    with pytest.raises(NotASolidError, match="point 9 is not a corner"):
        solid_of_corners([*CUBE, (0.4, 0.5, 0.6)])


def test_a_centre_of_mass_outside_is_refused() -> None:
    with pytest.raises(NotASolidError, match="outside the solid"):
        solid_of_corners(CUBE, (1.5, 0.5, 0.5))


@pytest.mark.parametrize(
    ("faces", "cause"),
    [
        (CUBE_FACES[:-1], "a hole"),
        ([face[::-1] for face in CUBE_FACES], "are oriented inwards"),
        ([*CUBE_FACES[:-1], CUBE_FACES[-1][::-1]], "one of them faces inwards"),
        (CUBE_FACES[:2], "2 faces enclose no volume"),
    ],
)
def test_a_mesh_that_is_open_or_inside_out_is_refused(faces: list[tuple[int, ...]], cause: str) -> None:
    with pytest.raises(NotASolidError, match=cause):
        solid_of_mesh(CUBE, faces)


def test_a_mesh_with_a_dent_is_rejected_with_its_missing_volume() -> None:
    points = [*CUBE, (0.5, 0.5, 0.5)]  # the top is drawn down to the middle: a pyramid of a sixth is missing
    top = [(1, 5, 8), (5, 7, 8), (7, 3, 8), (3, 1, 8)]
    with pytest.raises(NotASolidError, match=r"not convex: corner 9 is inside its hull; its volume is 16\.7 % less"):
        solid_of_mesh(points, [*CUBE_FACES[:-1], *top])


def test_ten_thousand_faces_are_refused_with_how_many_may_be() -> None:
    with pytest.raises(NotASolidError, match="corners; the maximum is 1000"):
        solid_of_corners(sphere(5002))
    with pytest.raises(NotASolidError, match=f"faces; the maximum is {MOST_FACES}"):
        solid_of_corners(sphere(300))


def test_a_ball_of_two_hundred_faces_is_nearly_a_ball() -> None:
    shape = solid_of_corners(sphere(102)).shape
    assert len(shape.faces) == MOST_FACES
    assert shape.volume == pytest.approx(4.0 / 3.0 * pi, rel=0.06)
    assert subtract(shape.moments(1.0), (0.4, 0.4, 0.4)) == pytest.approx((0.0, 0.0, 0.0), abs=0.02)
