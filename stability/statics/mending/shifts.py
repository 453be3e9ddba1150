"""The least shift of one brick in plan that lets a build stand, with what rests on it carried along; or several shifts.

A brick is tried further and further away along bearings all around. From the nearest place that stands the length is
halved down, and the bearing turned to the foot of the perpendicular on the line through two limits beside each other:
limits of tipping are straight. What is handed out stands, and falls where it is shorter by a millionth; that no other
bearing needs much less is shown on a ring of bearings, and known between them no better.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import atan2, ceil, floor, hypot, log10, pi

from stability.model import BodyId
from stability.name_order import in_order
from stability.statics.facts import Stability, Verdict
from stability.statics.mending.piling import Piling, Shift, bearing_shift

BEARINGS = 16
STEPS = (0.002, 0.01, 0.03, 0.07, 0.15, 0.3, 0.5, 0.75, 1.0)  # of the longest side of the brick
CLOSE = 1e-6  # share of a shift by which less is shown to be too little
TURN = 0.02  # [rad] between two limits that show which way the border runs
TURNS = 3
DIGITS = 4  # of a shift as people are told it, if that stands
ANGLE_DIGITS = 6  # of its bearing in radians
MOST_AT_ONCE = 12  # shifts
SIDES = 24  # bearings of the ring
RING = 0.97  # of the shift, that is shown not to be enough along these


@dataclass(frozen=True, slots=True)
class BrickShift:
    """A shift that lets it stand, by a verdict."""

    brick: BodyId
    shift: Shift  # along the ground [m]
    too_little: float  # [m] along the same bearing with which it is proven to fall
    shorter: int = 0  # of the bearings around, how many are proven not to do with a little less

    @property
    def length(self) -> float:
        """In plan [m]."""
        return hypot(*self.shift)


@dataclass(frozen=True, slots=True)
class SeveralShifts:
    """Shifts that let it stand together."""

    shifts: Sequence[tuple[BodyId, Shift]]
    too_little: float  # share of all of them with which it is proven to fall


class Shifting:
    """A build that falls, and what shifts make of it."""

    def __init__(self, piling: Piling, known: Callable[[], None] = lambda: None) -> None:
        """`known` is told of each verdict."""
        self.piling = piling
        self.carried = piling.carried()
        self.touching = piling.touching()
        self.asked = 0
        self._known = known
        self._lengths = {placed.brick.id: placed.brick.shape.length for placed in piling.bricks}

    def stands(self, shifts: Mapping[BodyId, Shift], upto: int | None = None) -> bool | None:
        """Whether it does with these bricks and what they carry moved; None if that is not known, or it cannot be."""
        self.asked += 1
        self._known()
        sums: dict[BodyId, Shift] = {}
        for brick, (x, y) in shifts.items():
            for name in self.carried[brick]:
                ox, oy = sums.get(name, (0.0, 0.0))
                sums[name] = ox + x, oy + y
        moved = self.piling.shifted(sums)
        if any(moved.crowds(self.carried[brick], self.touching) for brick in shifts):
            return None
        if upto is None and moved.falls_at_once():  # which is cheap to ask, and most trials do
            return False
        fall = moved.first_fall(upto)
        if fall is None:
            return True
        return False if fall[1].stability is Stability.UNSTABLE else None

    def least(
        self, brick: BodyId, others: Mapping[BodyId, Shift], upto: int | None = None, most: float | None = None
    ) -> BrickShift | None:
        """The least shift of one brick besides others, no longer than `most` [m]; None if none is found."""
        ox, oy = others.get(brick, (0.0, 0.0))

        def holds(length: float, bearing: float) -> bool | None:
            x, y = bearing_shift(length, bearing)
            return self.stands({**others, brick: (ox + x, oy + y)}, upto)

        bearings = [2.0 * pi * turn / BEARINGS for turn in range(BEARINGS)]
        fails = dict.fromkeys(bearings, 0.0)
        for step in STEPS:
            length = step * self._lengths[brick]
            if most is not None and fails and min(fails.values()) > most:
                break
            found = []
            for bearing in bearings:
                held = holds(length, bearing)
                if held:
                    found.append(self._halved(fails[bearing], length, bearing, holds))
                elif held is False:
                    fails[bearing] = length
            if found:
                low, high, bearing = self._turned(min(found, key=lambda each: each[1]), holds)
                told, round_bearing = rounded_up(high), round(bearing, ANGLE_DIGITS)
                shift = bearing_shift(told, round_bearing)
                if told > self._lengths[brick] or not holds(told, round_bearing):
                    shift = bearing_shift(high, bearing)
                ring = sum(holds(RING * high, 2.0 * pi * turn / SIDES) is False for turn in range(SIDES))
                return BrickShift(brick, shift, low, ring)
        return None

    @staticmethod
    def _halved(
        fails: float, held: float, bearing: float, holds: Callable[[float, float], bool | None]
    ) -> tuple[float, float, float]:
        """What fails and what holds along a bearing, close to each other, and the bearing."""
        while held - fails > 0.5 * CLOSE * held:
            middle = 0.5 * (fails + held)
            answer = holds(middle, bearing)
            if answer is None:
                break
            fails, held = (fails, middle) if answer else (middle, held)
        return fails, held, bearing

    def _turned(
        self, best: tuple[float, float, float], holds: Callable[[float, float], bool | None]
    ) -> tuple[float, float, float]:
        """The same along a better bearing, if there is one nearby."""
        for _ in range(TURNS):
            _, length, bearing = best
            beside = bearing + TURN
            if not holds(2.0 * length, beside):
                break
            other = self._halved(0.0, 2.0 * length, beside, holds)
            turned = _foot(bearing_shift(length, bearing), bearing_shift(*other[1:]))
            if not holds(length, turned):
                best = min(best, other, key=lambda each: each[1])
                break
            tried = self._halved(0.0, length, turned, holds)
            if tried[1] > length * (1.0 - CLOSE):
                break
            best = tried
        return best

    def candidates(self, turn: int, verdict: Verdict) -> list[BodyId]:
        """The bricks whose shift could change a fall at a stage: those that move or touch what does, or carry such."""
        whole, there = self.piling.whole(), self.piling.there(turn)
        moving = set(verdict.moving)
        near = moving | {b for name in moving for c in whole.contacts(name) for b in (c.lower, c.upper)}
        return in_order([name for name in self.carried if name in there and self.carried[name] & near & there])

    def several(self) -> SeveralShifts | None:
        """Shifts one after the other: each is the least that mends the first fall that is left; None if that fails."""
        shifts: dict[BodyId, Shift] = {}
        for _ in range(MOST_AT_ONCE):
            fall = self._first_fall(shifts)
            if fall is None:
                return self._shrunk(shifts)
            turn, verdict = fall
            best: BrickShift | None = None
            for brick in self.candidates(turn, verdict):
                found = self.least(brick, shifts, turn + 1, best.length if best else None)
                if found is not None and (best is None or found.length < best.length):
                    best = found
            if best is None:
                return None
            x, y = shifts.get(best.brick, (0.0, 0.0))
            shifts[best.brick] = x + best.shift[0], y + best.shift[1]
        return None

    def _first_fall(self, shifts: Mapping[BodyId, Shift]) -> tuple[int, Verdict] | None:
        sums: dict[BodyId, Shift] = {}
        for brick, (x, y) in shifts.items():
            for name in self.carried[brick]:
                ox, oy = sums.get(name, (0.0, 0.0))
                sums[name] = ox + x, oy + y
        return self.piling.shifted(sums).first_fall()

    def _shrunk(self, shifts: Mapping[BodyId, Shift]) -> SeveralShifts | None:
        """All that are needed, by as little as is enough of all alike."""
        needed = dict(shifts)
        for brick in list(needed):
            fewer = {name: shift for name, shift in needed.items() if name != brick}
            if fewer and self.stands(fewer):
                needed = fewer
        if not self.stands(needed):
            return None

        def holds(share: float, _: float) -> bool | None:
            return self.stands({name: (share * x, share * y) for name, (x, y) in needed.items()})

        low, high, _ = self._halved(0.0, 1.0, 0.0, holds)
        least = {name: (high * x, high * y) for name, (x, y) in needed.items()}
        told = {name: _longer(shift) for name, shift in least.items()}
        return SeveralShifts(list((told if self.stands(told) else least).items()), low / high)


def _foot(one: Shift, other: Shift) -> float:
    """The bearing of the foot of the perpendicular on the line through two shifts [rad]."""
    dx, dy = other[0] - one[0], other[1] - one[1]
    across = one[0] * dy - one[1] * dx
    return atan2(-across * dx, across * dy)


def rounded_up(length: float) -> float:
    """The next number of few digits [m]."""
    unit = 10.0 ** (floor(log10(length)) + 1 - DIGITS)
    return float(f"{unit * ceil(length / unit * (1.0 - CLOSE * CLOSE)):.{DIGITS}g}")


def _longer(shift: Shift) -> Shift:
    length = hypot(*shift)
    return (shift[0] * rounded_up(length) / length, shift[1] * rounded_up(length) / length) if length > 0.0 else shift
