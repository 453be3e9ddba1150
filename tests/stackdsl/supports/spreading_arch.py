"""A semicircular arch on spreading springings, by plane geometry of three hinges and by its line of thrust.

Written apart from the project: it shares no code with it. Mean radius 1, weight 1 per area, an even number of stones.
Each half turns about a hinge at its haunch, on the inner side, and both meet at a hinge at the crown, on the outer
side (Ochsendorf, Collapse of masonry structures, 2002). The arch falls when the force in some joint reaches an edge.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, sin, sqrt

Point = tuple[float, float]


@dataclass(frozen=True)
class Arch:
    stones: int
    thickness: float

    def corner(self, joint: int, radius: float) -> Point:
        angle = pi - pi * joint / self.stones
        return radius * cos(angle), radius * sin(angle)

    def inner(self, joint: int) -> Point:
        return self.corner(joint, 1 - self.thickness / 2)

    def outer(self, joint: int) -> Point:
        return self.corner(joint, 1 + self.thickness / 2)

    def stone(self, number: int) -> tuple[float, Point]:
        """Return area and centroid of a stone with plane faces, by the shoelace formula."""
        ring = [self.inner(number), self.outer(number), self.outer(number + 1), self.inner(number + 1)]
        area = x = z = 0.0
        for (a, b), (c, d) in zip(ring, ring[1:] + ring[:1], strict=True):
            twice = a * d - c * b
            area, x, z = area + twice / 2, x + twice * (a + c) / 6, z + twice * (b + d) / 6
        return abs(area), (x / area, z / area)

    def moved(self, hinge: int, spread: float) -> tuple[Callable[[Point, int], Point], Point, Point]:
        """Return the motion of points by their stone, and the two hinges, of the left half."""
        a, c = self.inner(hinge), self.outer(self.stones // 2)
        foot = (a[0] - spread, a[1])
        length = sqrt((c[0] - a[0]) ** 2 + (c[1] - a[1]) ** 2)
        crown = (0.0, foot[1] + sqrt(length**2 - foot[0] ** 2))
        before, after = (complex(*c) - complex(*a)) / length, (complex(*crown) - complex(*foot)) / length
        turn = after / before

        def move(point: Point, stone: int) -> Point:
            if stone < hinge:
                return point[0] - spread, point[1]
            place = complex(*foot) + turn * (complex(*point) - complex(*a))
            return place.real, place.imag

        return move, foot, crown

    def thrust(self, hinge: int, spread: float) -> float:
        """Return the horizontal thrust, from the moments of the half about its haunch."""
        move, foot, crown = self.moved(hinge, spread)
        stones = [(k, *self.stone(k)) for k in range(hinge, self.stones // 2)]
        return sum(area * (move(centre, k)[0] - foot[0]) for k, area, centre in stones) / (crown[1] - foot[1])

    def places(self, hinge: int, spread: float) -> list[float]:
        """Return the place of the force in each joint of the left half: 0 at its inner and 1 at its outer edge."""
        move, _, crown = self.moved(hinge, spread)
        push, half = self.thrust(hinge, spread), self.stones // 2
        found = []
        for joint in range(half + 1):
            above = [(k, *self.stone(k)) for k in range(joint, half)]
            weight = sum(area for _, area, _ in above)
            moment = sum(area * move(centre, k)[0] for k, area, centre in above) - push * crown[1]
            (x, z), (u, v) = move(self.inner(joint), joint), move(self.outer(joint), joint)
            found.append((moment - x * weight + z * push) / ((u - x) * weight - (v - z) * push))
        return found

    def is_borne(self, hinge: int, spread: float) -> bool:
        return all(-1e-9 <= place <= 1 + 1e-9 for place in self.places(hinge, spread))

    def hinge(self) -> int:
        """Return the joint of the hinge at the haunch as the springings begin to spread."""
        (only,) = (joint for joint in range(self.stones // 2) if self.is_borne(joint, 0.0))
        return only

    def largest_spread(self) -> float:
        """Return the movement of each springing at which the arch falls."""
        hinge, low, high = self.hinge(), 0.0, 0.0
        while self.is_borne(hinge, high):
            low, high = high, high + 0.01
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if self.is_borne(hinge, middle) else (low, middle)
        return low

    @property
    def weight(self) -> float:
        return sum(self.stone(number)[0] for number in range(self.stones))
