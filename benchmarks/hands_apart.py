"""Simulates flat planks with placement errors, and whether they stand, independently of the measured package.

Only the design and the random numbers come from the package. The target pose of a plank is relative to the planks that
carry it in the design, averaged over these; its own error is added, and it lies on the highest plank below it
(docs/design/samples.md). After each plank a linear program searches forces at the corners of all overlaps: vertical
forces first, which are cheap and mostly enough, then forces within friction pyramids.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, cos, hypot, sin

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.stats import norm

from benchmarks.equilibrium_programs import UP, Touch, UprightBox, answer_of, balanced
from stackdsl.sampling.samples import Draws

SAME = 1e-9  # [m] heights within this distance are equal
Point = tuple[float, float]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Plank:
    """Flat plank."""

    name: str
    x: float  # of its middle [m]
    y: float
    bottom: float
    turn: float  # of its length from +x [rad]
    size: tuple[float, float, float]  # [m]
    mass: float
    level: int  # in the design

    @property
    def top(self) -> float:
        """Return the height of the top [m]."""
        return self.bottom + self.size[2]

    @property
    def middle(self) -> tuple[float, float, float]:
        """Return the centre [m]."""
        return self.x, self.y, self.bottom + 0.5 * self.size[2]

    def outline(self) -> list[Point]:
        """Return the corners in plan, counter-clockwise."""
        c, s, a, b = cos(self.turn), sin(self.turn), 0.5 * self.size[0], 0.5 * self.size[1]
        return [(self.x + c * u - s * v, self.y + s * u + c * v) for u, v in ((a, b), (-a, b), (-a, -b), (a, -b))]


def shared(one: Plank, other: Plank) -> list[Point]:
    """Return the corners of the overlap of two planks in plan; none if it has no area."""
    if hypot(one.x - other.x, one.y - other.y) > hypot(*one.size) + hypot(*other.size):
        return []
    piece, border = one.outline(), other.outline()
    for (ax, ay), (bx, by) in zip(border, border[1:] + border[:1], strict=True):
        inside = [(bx - ax) * (y - ay) - (by - ay) * (x - ax) for x, y in piece]
        kept: list[Point] = []
        for k, (x, y) in enumerate(piece):
            if inside[k] >= 0.0:
                kept.append((x, y))
            after = (k + 1) % len(piece)
            if inside[k] * inside[after] < 0.0:
                share = inside[k] / (inside[k] - inside[after])
                u, v = piece[after]
                kept.append((x + share * (u - x), y + share * (v - y)))
        piece = kept
    area = sum(x * v - u * y for (x, y), (u, v) in zip(piece, piece[1:] + piece[:1], strict=True))
    return piece if area > 0.0 else []


def set_down(design: Sequence[Plank], draws: Draws, position: float, yaw: float) -> list[Plank]:
    """Return one sample: the planks with errors of these standard deviations [m], [rad]."""
    there: list[Plank] = []
    for turn, plank in enumerate(design):
        below = [k for k in range(turn) if abs(design[k].top - plank.bottom) < SAME and shared(plank, design[k])]
        says = [_as_seen_from(design[k], there[k], plank) for k in below] or [(plank.x, plank.y, 0.0)]
        x, y, turned = (sum(each) / len(says) for each in zip(*says, strict=True))
        error = norm.ppf(draws.uniform(plank.name)[:3, 0])
        x, y = x + position * float(error[0]), y + position * float(error[1])
        angle = plank.turn + turned + yaw * float(error[2])
        lying = Plank(plank.name, x, y, 0.0, angle, plank.size, plank.mass, plank.level)
        bottom = max((other.top for other in there if shared(lying, other)), default=0.0)
        there.append(Plank(plank.name, x, y, bottom, angle, plank.size, plank.mass, plank.level))
    return there


def _as_seen_from(designed: Plank, lies: Plank, plank: Plank) -> tuple[float, float, float]:
    """Return the target pose of a plank relative to one below it: position, and rotation from the design."""
    turned = lies.turn - designed.turn
    u, v = plank.x - designed.x, plank.y - designed.y
    return lies.x + cos(turned) * u - sin(turned) * v, lies.y + sin(turned) * u + cos(turned) * v, turned


def falls_at(planks: Sequence[Plank], friction: float) -> tuple[int | None, int]:
    """Return the first level at which not all planks stand, and the number of solved programs.

    The level is 0 if all stand, and None if undecided.
    """
    contacts: list[Touch] = []
    for count, plank in enumerate(planks, 1):
        contacts += _contacts(planks[:count])
        if _held_upwards(planks[:count], contacts):
            continue
        boxes = [UprightBox(each.middle, each.size, each.mass) for each in planks]
        stands = answer_of(boxes[:count], contacts, friction)
        if stands is not True:
            return (plank.level if stands is False else None), count
    return 0, len(planks)


def _contacts(planks: Sequence[Plank]) -> list[Touch]:
    """Return the contacts below the last of some planks."""
    last, number = planks[-1], len(planks) - 1
    if last.bottom < SAME:
        return [(None, number, UP, [(x, y, last.bottom) for x, y in last.outline()])]
    return [
        (k, number, UP, [(x, y, last.bottom) for x, y in corners])
        for k, other in enumerate(planks[:-1])
        if abs(other.top - last.bottom) < SAME and (corners := shared(last, other))
    ]


def _held_upwards(planks: Sequence[Plank], contacts: Sequence[Touch]) -> bool:
    """Return whether vertical forces alone balance all weights."""
    rows: list[int] = []
    columns: list[int] = []
    values: list[float] = []
    column = 0
    for lower, upper, _, corners in contacts:
        for x, y, _ in corners:
            for body, sign in ((upper, 1.0), (lower, -1.0)):
                if body is not None:
                    plank = planks[body]
                    long = plank.size[0]
                    rows += range(3 * body, 3 * body + 3)
                    columns += [column] * 3
                    values += [sign, sign * (x - plank.x) / long, sign * (y - plank.y) / long]
            column += 1
    loads: Array = np.zeros(3 * len(planks))
    loads[::3] = [plank.mass / planks[0].mass for plank in planks]
    matrix = coo_matrix((values, (rows, columns)), shape=(len(loads), column)).tocsc()
    return balanced(matrix, loads)


def turn_of(orientation: tuple[float, float, float, float]) -> float:
    """Return the rotation about the vertical of a quaternion x, y, z, w without any other rotation [rad]."""
    x, y, z, w = orientation
    assert hypot(x, y) < SAME, "it does not lie flat"
    return 2.0 * atan2(z, w)
