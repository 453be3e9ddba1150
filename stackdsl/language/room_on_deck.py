"""Finds how boxes that overhang a deck, or are inside each other, fit on it: by horizontal moves along its sides.

The warning about an overhang and the error about boxes inside each other use the same moves, so that they agree. A box
that moves pushes the boxes of its layer in front of it. Boxes count with their bounding boxes.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Final, TypeAlias

from stability.model import Vec3
from stackdsl.language.yaml.source import Area

PLAN: Final = (0, 1)  # axes
MOST_TRIED: Final = 60  # other boxes of a layer among which a free place is looked for
TOUCHING: Final = 1e-6  # [m] deeper boxes are inside each other
NAMES: Final = (("-x", "+x"), ("-y", "+y"))

Bounds: TypeAlias = tuple[Vec3, Vec3]


@dataclass(slots=True)
class Room:
    """Boxes, and a deck that includes the permitted overhang."""

    boxes: Sequence[Bounds]
    deck: Area
    moves: dict[int, list[float]] = field(default_factory=dict)  # of boxes by index, along x and y [m]

    def moves_of(self, box: int) -> Mapping[int, Sequence[float]] | None:
        """Return the moves with which a box and all boxes inside it fit on the deck; None if there is no room."""
        self.moves = {}
        cluster = self._cluster(box)
        for each in cluster:
            for axis in PLAN:
                before, beyond = (self.beyond(each, axis, sign) for sign in (-1, 1))
                if max(before, beyond) > TOUCHING:
                    pushed = self._pushed(each, axis, 1 if before > beyond else -1, max(before, beyond))
                    if pushed is None:
                        return None
                    self._apply(axis, pushed)
        for number, one in enumerate(cluster):
            for other in cluster[:number]:
                if self._collide(one, other) and not self._parted(one, other):
                    return None
        return {each: move for each, move in sorted(self.moves.items()) if max(map(abs, move)) > TOUCHING}

    def move_to_only_free_place(self, box: int) -> str:
        """Return the move of a box to the only free place of its size in its layer; empty if there is none or several.

        Places touch sides of the deck or of other boxes, so a hole that is larger than the box has several.
        """
        layer = [other for other in range(len(self.boxes)) if other != box and self._in_one_layer(box, other)]
        if len(layer) > MOST_TRIED:
            return ""
        low = self.boxes[box][0]
        self.moves, free = {}, set[tuple[float, float]]()
        for x, y in product(*(self._touching(box, axis, layer) for axis in PLAN)):
            self.moves = {box: [x - low[0], y - low[1]]}
            if not any(self._collide(box, other) for other in layer):
                free.add((round(x - low[0], 6), round(y - low[1], 6)))
        self.moves = {}
        return " and ".join(_told(free.pop())) if len(free) == 1 else ""

    def _touching(self, box: int, axis: int, layer: Sequence[int]) -> set[float]:
        """Return the lower ends of a box along an axis at which it touches another box or a side of the deck."""
        size = self.boxes[box][1][axis] - self.boxes[box][0][axis]
        least, most = self.deck[0][axis], self.deck[1][axis] - size
        ends = {least, most, *(self.boxes[other][1][axis] for other in layer)}
        ends |= {self.boxes[other][0][axis] - size for other in layer}
        return {round(end, 9) for end in ends if least - TOUCHING <= end <= most + TOUCHING}

    def is_crowded(self, box: int) -> bool:
        """Return whether another box of the same layer is inside a box."""
        return len(self._cluster(box)) > 1

    def beyond(self, box: int, axis: int, sign: int) -> float:
        """Return the distance by which a box reaches beyond a side of the deck [m]; negative inside."""
        low, high = self._span(box, axis)
        return high - self.deck[1][axis] if sign > 0 else self.deck[0][axis] - low

    def _span(self, box: int, axis: int) -> tuple[float, float]:
        low, high = self.boxes[box]
        moved = self.moves[box][axis] if axis in PLAN and box in self.moves else 0.0
        return low[axis] + moved, high[axis] + moved

    def _overlap(self, one: int, other: int, axis: int) -> float:
        (low, high), (other_low, other_high) = self._span(one, axis), self._span(other, axis)
        return min(high, other_high) - max(low, other_low)

    def _in_one_layer(self, one: int, other: int) -> bool:
        """Return whether boxes overlap by more than half of a height, so that one cannot lie on the other."""
        least = min(high - low for low, high in (self._span(one, 2), self._span(other, 2)))
        return self._overlap(one, other, 2) > 0.5 * least

    def _collide(self, one: int, other: int) -> bool:
        inside = all(self._overlap(one, other, axis) > TOUCHING for axis in PLAN)
        return one != other and inside and self._in_one_layer(one, other)

    def _cluster(self, box: int) -> list[int]:
        """Return a box, the boxes inside it, the boxes inside these, and so on, by index."""
        cluster, waiting = {box}, [box]
        while waiting:
            one = waiting.pop()
            new = {other for other in range(len(self.boxes)) if self._collide(one, other)} - cluster
            cluster |= new
            waiting += new
        return sorted(cluster)

    def _parted(self, one: int, other: int) -> bool:
        """Move one of two boxes, the least way in sum that leaves all moved boxes on the deck."""
        ways = [way for pair in ((one, other), (other, one)) for way in self._ways_out(*pair)]
        if not ways:
            return False
        _, axis, pushed = min(ways, key=lambda way: way[0])
        self._apply(axis, pushed)
        return True

    def _ways_out(self, box: int, other: int) -> Iterator[tuple[float, int, Mapping[int, float]]]:
        for axis in PLAN:
            (low, high), (other_low, other_high) = self._span(box, axis), self._span(other, axis)
            for sign, by in ((1, other_high - low), (-1, high - other_low)):
                pushed = self._pushed(box, axis, sign, by)
                if pushed is not None:
                    yield round(sum(map(abs, pushed.values())), 9), axis, pushed

    def _pushed(self, box: int, axis: int, sign: int, by: float) -> Mapping[int, float] | None:
        """Return the moves of a box and of the boxes that it pushes; None if one of them leaves the deck."""
        pushed, waiting = {box: by}, [box]
        while waiting:
            one = waiting.pop()
            if self.beyond(one, axis, sign) + pushed[one] > TOUCHING:
                return None
            for other in range(len(self.boxes)):
                ahead = sign * (sum(self._span(other, axis)) - sum(self._span(one, axis)))
                beside = self._overlap(one, other, 1 - axis) > TOUCHING and self._in_one_layer(one, other)
                if other == box or not beside or ahead <= 0.0:
                    continue
                push = pushed[one] + self._overlap(one, other, axis)
                if push > pushed.get(other, 0.0) + TOUCHING:
                    pushed[other] = push
                    waiting.append(other)
        return {each: sign * push for each, push in pushed.items()}

    def _apply(self, axis: int, pushed: Mapping[int, float]) -> None:
        for box, move in pushed.items():
            self.moves.setdefault(box, [0.0, 0.0])[axis] += move


def room_text(room: Room, box: int, names: Sequence[str]) -> str:
    """Return the remedy for a box: `move 'C4' 100 mm towards -x; move 'C3' 250 mm towards -x`."""
    moves = room.moves_of(box)
    low, high = room.boxes[box]
    if any(high[axis] - low[axis] > room.deck[1][axis] - room.deck[0][axis] + TOUCHING for axis in PLAN):
        return "turn it, or give the right `deck`, since it is larger than the deck"
    if moves is None:
        return "there is no room for it on the deck beside the other boxes of its layer: take a box out of this layer"
    return "; ".join(f"move {names[each]} {' and '.join(_told(move))}" for each, move in moves.items())


def _told(move: Sequence[float]) -> Iterator[str]:
    for axis in PLAN:
        if abs(move[axis]) > TOUCHING:
            yield f"{millimetres(abs(move[axis]))} mm towards {NAMES[axis][move[axis] > 0.0]}"


def millimetres(length: float) -> str:
    """Format a length [m] in millimetres, to a micrometre."""
    return f"{round(1000.0 * length, 3):.12g}"
