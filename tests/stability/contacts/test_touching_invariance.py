"""Contacts do not hang on size, place and yaw, and their normals part the bodies."""

from math import cos, pi, radians, sin, sqrt

from hypothesis import example, given
from hypothesis import strategies as st

from stability.contacts.bodies import BoxSolid
from stability.geometry.box_distance import boxes_apart
from stability.geometry.vectors import multiply, rotate
from stability.model import Quaternion, Vec3
from tests.stability.contacts.touching import (
    TOLERANCES,
    L,
    T,
    W,
    brick,
    contact,
    ladder,
    leaning_pair,
    plank,
    same_points,
    touch,
    yawed,
)


def scenes() -> list[tuple[BoxSolid, BoxSolid]]:
    v = leaning_pair(radians(60.0))
    return [
        (plank("a", (0.0, 0.0, 0.0)), plank("b", (0.01, 0.003, T), yawed(0.5))),
        (plank("a", (0.0, 0.0, 0.0)), plank("b", (0.0, W, 0.0))),
        (plank("a", (0.0, 0.0, 0.0)), plank("b", (L, 0.0, T))),
        (plank("a", (0.0, 0.0, 0.0)), plank("b", (L * (1.0 - 1e-6), 0.0, T))),
        (ladder(1.1), brick("floor", (1.0, 0.01, 0.1), (0.0, 0.0, -0.05))),
        v,
    ]


@given(
    st.integers(0, 5),
    st.sampled_from([1e-3, 1.0, 1e3]),
    st.floats(-pi, pi),
    st.sampled_from([(0.0, 0.0, 0.0), (1000.0, -1000.0, 50.0)]),
)
@example(2, 1e-3, 0.7, (1000.0, -1000.0, 50.0))
def test_size_place_and_yaw_change_nothing(scene: int, scale: float, yaw: float, shift: Vec3) -> None:
    pair = scenes()[scene]
    plain = touch(*pair)

    def placed(point: Vec3) -> Vec3:
        x, y, z = rotate(yawed(yaw), point)
        return (scale * x + shift[0], scale * y + shift[1], scale * z + shift[2])

    def remade(body: BoxSolid) -> BoxSolid:
        size = (scale * body.size[0], scale * body.size[1], scale * body.size[2])
        return brick(body.id, size, placed(body.pose.position_W), multiply(yawed(yaw), body.pose.orientation))

    found = touch(remade(pair[0]), remade(pair[1]))
    if plain is None or found is None:
        assert plain is found
        return
    rounding = 1e-12 * scale + 1e-15 * 3e3 * (shift[0] != 0.0)
    assert same_points(found.points_W, [placed(point) for point in plain.points_W], rounding)
    sign = 1.0 if found.lower == plain.lower else -1.0
    expected = [rotate(yawed(yaw), normal) for normal in plain.normals_W]
    assert same_points([(sign * x, sign * y, sign * z) for x, y, z in found.normals_W], expected, 1e-11)


def normalised(q: Quaternion) -> Quaternion:
    length = sqrt(sum(x * x for x in q))
    return (q[0] / length, q[1] / length, q[2] / length, q[3] / length)


ORIENTATIONS = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: sum(x * x for x in q) > 0.1).map(normalised)
SIZES = st.tuples(*[st.floats(0.3, 2.0)] * 3)


@given(SIZES, SIZES, ORIENTATIONS, st.floats(-pi, pi), st.floats(0.2, pi - 0.2))
def test_every_normal_parts_the_bodies_at_every_point(
    size_a: Vec3, size_b: Vec3, orientation: Quaternion, azimuth: float, polar: float
) -> None:
    # b comes in along a line until it touches; a plane through the contact then has a on one side and b on the other.
    away = (sin(polar) * cos(azimuth), sin(polar) * sin(azimuth), cos(polar))
    a = brick("a", size_a, (0.0, 0.0, 0.0))
    near, far = 0.0, 10.0
    for _ in range(50):
        middle = 0.5 * (near + far)
        b = brick("b", size_b, (middle * away[0], middle * away[1], middle * away[2]), orientation)
        near, far = (middle, far) if _deepest(a, b) > 0.0 else (near, middle)
    found = contact(a, brick("b", size_b, (far * away[0], far * away[1], far * away[2]), orientation))
    sign = 1.0 if found.lower == "a" else -1.0
    # Faces that are parallel to a degree may be taken as parallel: the tolerance, and no more, is their error.
    within = TOLERANCES.gap * min(*size_a, *size_b)
    for n, p in ((n, p) for n in found.normals_W for p in found.points_W):
        heights_a = [sign * sum(c * (v - q) for c, v, q in zip(n, corner, p, strict=True)) for corner in a.corners_W]
        heights_b = [sign * sum(c * (v - q) for c, v, q in zip(n, corner, p, strict=True)) for corner in b.corners_W]
        assert max(heights_a) <= within
        assert min(heights_b) >= -within


def _deepest(a: BoxSolid, b: BoxSolid) -> float:
    return -boxes_apart(a.size, a.pose, b.size, b.pose).gap
