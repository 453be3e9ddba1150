"""Verifies verdicts on houses of cards by linear programs that are independent of the statics.

The two cards of a V lean on each other along the inner ones of their upper edges; planks lie on the highest edges, and
cards stand on their lowest ones, on the ground or on planks. Along an edge below a plank forces act at both ends of the
covered part. Two edges in contact admit every normal between the extreme ones that both admit (docs/design/engines.md):
each edge admits the normals between those of its two faces. Bodies that are closer than the contact distance touch in
the package, but not here.

python -m benchmarks.card_houses_apart            100 samples for each pair of placement errors

python -m benchmarks.card_houses_apart            100 samples for each pair of placement errors
python -m benchmarks.card_houses_apart --write    the same, to docs/data
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import cos, sin

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from benchmarks.equilibrium_programs import UP, Touch, UprightBox, answer_of
from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.human_error import FRICTION, HANDS, SCENES, case_of
from stability.geometry.box import Box
from stability.model import Quaternion
from stability.problem import Placed
from stackdsl.sampling.placement_errors import PlacementSampler
from stackdsl.sampling.sample_outcomes import sample_outcomes_of
from stackdsl.sampling.samples import BuildPlan, Draws, build_plan_of

Array = NDArray[np.float64]
NEAR = 1e-6  # [m]
STEEP = 0.02  # largest vertical part of the direction of a flat card's length


@dataclass(frozen=True)
class Card:
    """Box given by its middle, its directions (rows), half of its sizes [m] and its mass."""

    middle: Array
    directions: Array
    half: Array
    mass: float

    @property
    def leans(self) -> bool:
        """Return whether the card belongs to a V."""
        return bool(abs(self.directions[0, 2]) > STEEP)

    def edge(self, end: float, side: float) -> Array:
        """Return (2, 3) one of the four edges across the length of the card, by its end and its face."""
        at = self.middle + end * self.half[0] * self.directions[0] + side * self.half[2] * self.directions[2]
        return np.stack([at - self.half[1] * self.directions[1], at + self.half[1] * self.directions[1]])

    def edges(self) -> list[tuple[float, float, Array]]:
        """Return all four edges, the lowest first."""
        found = [(end, side, self.edge(end, side)) for end in (-1.0, 1.0) for side in (-1.0, 1.0)]
        return sorted(found, key=lambda each: float(each[2][:, 2].sum()))


def card_of(placed: Placed) -> Card:
    """Return the card of a brick."""
    assert isinstance(placed.brick.shape, Box)
    half = 0.5 * np.array(placed.brick.shape.size)
    return Card(np.array(placed.pose.position_W), _directions(placed.pose.orientation), half, placed.brick.mass)


def stands(bricks: Sequence[Placed], friction: float) -> bool | None:
    """Return whether bricks stand; None if friction pyramids inside and outside the cone disagree."""
    cards = [card_of(each) for each in bricks]
    boxes = [UprightBox(_point(card.middle), _point(2.0 * card.half), card.mass) for card in cards]
    return answer_of(boxes, [*_touches(cards)], friction)


def _touches(cards: Sequence[Card]) -> Iterator[Touch]:
    for index, card in enumerate(cards):
        if not card.leans:
            continue
        lowest, inner, highest = (card.edges()[k][2] for k in (0, 2, 3))
        if abs(lowest[0, 2]) < NEAR:
            yield None, index, UP, [_point(each) for each in lowest]
        for number, other in enumerate(cards):
            if other.leans and number > index and _same(inner, other.edges()[2][2]):
                for normal in _between(card, other):
                    yield index, number, normal, [_point(each) for each in inner]
            elif not other.leans:
                pairs = ((number, index, lowest, 1.0), (index, number, highest, -1.0))
                for lower, upper, edge, side in pairs:
                    if on := _covered(edge, other, side):
                        yield lower, upper, UP, on


def _same(one: Array, other: Array) -> bool:
    """Return whether two edges are equal, in either direction."""
    return any(bool(np.abs(one - each).max() < NEAR) for each in (other, other[::-1]))


def _covered(edge: Array, plank: Card, side: float) -> list[tuple[float, ...]]:
    """Return the ends of the part of an edge on the upper (1) or lower (-1) face of a plank; none without overlap."""
    up = 1.0 if plank.directions[2, 2] > 0.0 else -1.0
    seen = (edge - plank.middle) @ plank.directions.T
    if np.abs(seen[:, 2] * up - side * plank.half[2]).max() > NEAR:
        return []
    begin, along, shares = seen[0], seen[1] - seen[0], [0.0, 1.0]
    for axis in (0, 1):
        for sign in (-1.0, 1.0):  # sign * (begin + share * along) <= half
            slope, room = sign * along[axis], plank.half[axis] - sign * begin[axis]
            if slope > 0.0:
                shares[1] = min(shares[1], room / slope)
            elif slope < 0.0:
                shares[0] = max(shares[0], room / slope)
            elif room < 0.0:
                return []
    return [_point(edge[0] + share * (edge[1] - edge[0])) for share in shares] if shares[0] < shares[1] else []


def _between(one: Card, other: Card) -> list[tuple[float, float, float]]:
    """Return the extreme normals from one card to the other that both inner upper edges admit."""
    away = other.middle - one.middle
    across = np.array([away[0], away[1], 0.0]) / np.hypot(away[0], away[1])
    (low, high), (other_low, other_high) = _angles(one, across), _angles(other, -across)
    ends = max(low, -other_high), min(high, -other_low)
    return [_point(cos(angle) * across + sin(angle) * np.array(UP)) for angle in ends]


def _angles(card: Card, across: Array) -> tuple[float, float]:
    """Return the least and greatest elevation of the normals of the faces beside a card's inner upper edge [rad]."""
    end, side, _ = card.edges()[2]
    faces = end * card.directions[0], side * card.directions[2]
    low, high = sorted(float(np.arctan2(face[2], face @ across)) for face in faces)
    return low, high


def _directions(orientation: Quaternion) -> Array:
    x, y, z, w = orientation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
            [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
            [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _point(vector: Array) -> tuple[float, float, float]:
    x, y, z = (float(each) for each in vector)
    return x, y, z


def measured(position: float, yaw: float, count: int) -> Row:
    """Return the verdicts of the package and of linear programs on the first samples with placement errors."""
    case = case_of(SCENES["card house"][0], position, yaw, count)
    draws = Draws(case.scenario.seed, case.scenario.scenario, 0, count)
    design = build_plan_of(case.timeline)
    ours, hands = sample_outcomes_of(design, draws).values.tolist(), PlacementSampler(design, draws).build()
    apart = [falls_at(design, hands.placed(sample)) for sample in range(count)]
    not_said = sum(level is None for level in apart)
    alike = sum(level == said for level, said in zip(apart, ours, strict=True))
    return {
        "hands": f"{position:g} mm, {yaw:g} deg",
        "samples": count,
        "stand": sum(level == 0 for level in apart),
        "alike": alike,
        "contradicted": count - alike - not_said,
        "not_said": not_said,
    }


def falls_at(design: BuildPlan, placed: Sequence[Placed]) -> int | None:
    """Return the level at which a sample falls, 0 if it stands, None if undecided."""
    there: list[Placed] = []
    for moment in design.moments:
        there += [placed[part.number] for unit in moment.units for part in unit.parts]
        if (found := stands(there, FRICTION)) is not True:
            return moment.level if found is False else None
    return 0


def main() -> None:
    """Measure and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--samples", type=int, default=100)
    chosen = arguments.parse_args()
    rows = {f"{position:g} mm, {yaw:g} deg": measured(position, yaw, chosen.samples) for position, yaw in HANDS}
    for name, row in rows.items():
        Console().print(name, row)
    if chosen.write:
        record("card-houses-apart", "python -m benchmarks.card_houses_apart --write", {"hands": rows})


if __name__ == "__main__":
    main()
