"""Rows of stones between two slanted planes: whether loads pull them tight does not hang on how they are looked at."""

from dataclasses import dataclass, replace
from math import cos, pi, radians, sin, tan
from random import Random

import pytest

from stability.geometry.solid_making import prism
from stability.model import Brick, Plane, Pose, Vec3
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly


@dataclass(frozen=True, slots=True)
class Row:
    """Stones between joints that lean by some angles from the vertical [deg], to +x going up; lengths in metres."""

    leans: tuple[float, ...]
    densities: tuple[float, ...]  # [kg/m3]
    friction: float
    width: float = 0.08  # of each stone, at its foot
    height: float = 0.06
    depth: float = 0.08
    turn: float = 0.0  # about the vertical [rad]
    shift_W: Vec3 = (0.0, 0.0, 0.0)

    @classmethod
    def at_random(cls, seed: int) -> "Row":
        random = Random(seed)
        count, spread = random.randint(1, 5), random.uniform(0.0, 25.0)
        leans = [-spread + 2.0 * spread * i / count + random.uniform(-5.0, 5.0) for i in range(count + 1)]
        densities = tuple(random.choice([600.0, 6000.0]) for _ in range(count))
        return cls(tuple(leans), densities, random.choice([0.2, 0.6, 1.0, 1.3]))

    def scaled(self, by: float) -> "Row":
        return replace(self, width=by * self.width, height=by * self.height, depth=by * self.depth)

    def verdict(self, prefix: str = "s", backwards: bool = False) -> Stability:
        rises = [self.height * tan(radians(lean)) for lean in self.leans]
        stones = []
        for i, density in enumerate(self.densities):
            foot, end = i * self.width, (i + 1) * self.width
            made = prism(
                [(foot, 0.0), (end, 0.0), (end + rises[i + 1], self.height), (foot + rises[i], self.height)], self.depth
            )
            number = len(self.densities) - i if backwards else i
            turn = (0.0, 0.0, sin(0.5 * self.turn), cos(0.5 * self.turn))
            brick = Brick(f"{prefix}{number}", made.shape, density * made.shape.volume)
            stones.append(Placed(brick, Pose(self._at(*made.centre_of_mass), turn)))
        ends = (("west", 0.0, self.leans[0], 1.0), ("east", len(stones) * self.width, self.leans[-1], -1.0))
        planes = tuple(self._plane(name, x, lean, side) for name, x, lean, side in ends)
        return Assembly(planes, self.friction).add_all(stones[::-1] if backwards else stones).stability

    def _plane(self, name: str, x: float, lean: float, side: float) -> Plane:
        along, up = side * cos(radians(lean)), -side * sin(radians(lean))
        normal_W = (along * cos(self.turn), along * sin(self.turn), up)
        return Plane(name, self._at(x, 0.0, 0.0), normal_W, self.friction)

    def _at(self, x: float, y: float, z: float) -> Vec3:
        dx, dy, dz = self.shift_W
        return x * cos(self.turn) - y * sin(self.turn) + dx, x * sin(self.turn) + y * cos(self.turn) + dy, z + dz


SEEDS = range(20)


@pytest.mark.parametrize("seed", [*SEEDS[:6], *(pytest.param(seed, marks=pytest.mark.slow) for seed in SEEDS[6:])])
def test_size_weight_bearing_place_names_and_order_change_no_verdict(seed: int) -> None:
    row = Row.at_random(seed)
    found = {
        row.verdict(),
        row.scaled(0.01).verdict(),
        row.scaled(100.0).verdict(),
        replace(row, densities=tuple(30.0 * density for density in row.densities)).verdict(),
        replace(row, turn=1.1).verdict(),
        replace(row, shift_W=(300.0, -200.0, 1.0)).verdict(),
        replace(row, turn=pi).verdict("z", backwards=True),
    }
    assert len(found) == 1


def test_most_rows_between_planes_that_open_upwards_pull_themselves_tight() -> None:
    opening = [row for row in map(Row.at_random, SEEDS) if row.leans[-1] - row.leans[0] > 10.0]
    assert sum(row.verdict() is Stability.STABLE for row in opening) > 0.8 * len(opening)


def test_no_row_between_planes_that_lean_inwards_is_proven_to_stand() -> None:
    for seed in SEEDS:
        row = Row.at_random(seed)
        inwards = replace(row, leans=(3.0, *(3.0 - 6.0 * i / len(row.densities) for i in range(1, len(row.leans)))))
        assert inwards.verdict() is not Stability.STABLE
