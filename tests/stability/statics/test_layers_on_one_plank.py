"""Planks in layers that lean on a single one (Fig. 13 of the publication, as scenarios/user_test reads it).

What they need of friction comes from a linear program in the plane, which knows nothing of `stability.statics`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog

from stability.problem import Stability
from stability.statics.assembly import Assembly
from tests.stability.statics.closed_forms import LENGTH, PLANK, THICKNESS, brick_at, leaning, level_ground

Array = NDArray[np.float64]
ANGLE = radians(70.0)
SLACK = 1e-5  # of the friction: what the linear program leaves open
C, S = cos(ANGLE), sin(ANGLE)
LAYER = THICKNESS / S  # [m] from foot to foot


@dataclass(frozen=True, slots=True)
class Push:
    """A force that one plank may get at a point, and another one gives, in the plane; one of the edges of a cone."""

    on: int
    by: int | None  # None: the ground
    at: Array
    force: Array


def centres(layers: int) -> list[Array]:
    """Of the right plank, and of those on the left from the lowest one; their peak stands above the origin."""
    out, up = (LENGTH * C + THICKNESS * S) / 2.0, (LENGTH * S + THICKNESS * C) / 2.0
    return [np.array([out, up]), *(np.array([-out - layer * LAYER, up]) for layer in range(layers))]


def pushes(layers: int, friction: float) -> Iterator[Push]:
    """Feet on the ground, the peak where two edges meet, and the layers, which press on each other at two ends."""
    foot = np.array([LENGTH * C, 0.0])
    yield from cone(0, None, foot, [(0.0, 1.0)], friction)
    # The faces that meet at the peak stand at the angle, so the normals of their edges reach as far off the level.
    yield from cone(0, 1, np.array([0.0, LENGTH * S]), [(S, C), (S, -C)], friction)
    for layer in range(layers):
        own = -foot - np.array([layer * LAYER, 0.0])
        yield from cone(layer + 1, None, own, [(0.0, 1.0)], friction)
        if layer:
            for along in (LAYER * C, LENGTH):
                at = own + along * np.array([C, S])
                yield from cone(layer + 1, layer, at, [(-S, C)], friction)


def cone(on: int, by: int | None, at: Array, normals: Sequence[tuple[float, float]], friction: float) -> Iterator[Push]:
    for x, z in normals:
        for side in (-friction, friction):
            yield Push(on, by, at, np.array([x - side * z, z + side * x]))


def balanced_in_the_plane(layers: int, friction: float) -> bool:
    """Whether such forces can carry the weight of every plank, one each."""
    middles = centres(layers)
    given = list(pushes(layers, friction))
    rows = np.zeros((3 * len(middles), len(given)))
    for column, push in enumerate(given):
        for plank, force in ((push.on, push.force), (push.by, -push.force)):
            if plank is not None:
                x, z = push.at - middles[plank]
                rows[3 * plank : 3 * plank + 3, column] += (force[0], force[1], x * force[1] - z * force[0])
    weights = np.tile([0.0, 1.0, 0.0], len(middles))
    return bool(linprog(np.zeros(len(given)), A_eq=rows, b_eq=weights).status == 0)


def least_friction(layers: int) -> float:
    """By bisection."""
    falls, stands = 0.0, 2.0
    while stands - falls > SLACK / 10.0:
        middle = (falls + stands) / 2.0
        falls, stands = (falls, middle) if balanced_in_the_plane(layers, middle) else (middle, stands)
    return stands


def judged(layers: int, friction: float) -> Stability:
    x, _, z = leaning("", ANGLE).pose.position_W
    left, right = (0.0, -sin(ANGLE / 2.0), 0.0, cos(ANGLE / 2.0)), (0.0, -cos(ANGLE / 2.0), 0.0, sin(ANGLE / 2.0))
    planks = [brick_at("right", PLANK, (2.0 * LENGTH * C - x, 0.0, z), right)]
    planks += [brick_at(f"left{layer}", PLANK, (x - layer * LAYER, 0.0, z), left) for layer in range(layers)]
    return Assembly(planes=(level_ground(friction),), friction=friction).add_all(planks).stability


@pytest.mark.parametrize(("layers", "friction"), [(1, 0.149), (2, 0.365), (3, 0.548)])
def test_the_friction_that_the_right_plank_needs_grows_with_the_planks_on_the_left(
    layers: int, friction: float
) -> None:
    #   /// \      two stand with a friction of 0.5, and a third pushes the right one over
    limit = least_friction(layers)
    assert limit == pytest.approx(friction, abs=5e-4)
    assert judged(layers, limit * (1.0 + SLACK)) is Stability.STABLE
    assert judged(layers, limit * (1.0 - SLACK)) is Stability.UNSTABLE


def test_one_plank_on_either_side_needs_what_the_closed_form_says() -> None:
    assert least_friction(1) == pytest.approx((C / S - THICKNESS / LENGTH) / 2.0, abs=SLACK)
