"""Searches for repairs of a build that falls: shifts of bricks in plan, and props."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import atan2, ceil, copysign, cos, floor, hypot, inf, log10, pi, sin
from typing import TypeAlias

from stability.analysis.building_order import least_props
from stability.analysis.piling import EXACT, Piling, Shift, ShiftedBuild
from stability.analysis.subset_search import OnProgress, Part, Subsets, ignore_progress, props_of
from stability.model import BodyId
from stability.name_order import in_order
from stability.problem import Stability, Verdict


def bearing_shift(length: float, bearing: float) -> Shift:
    """Return a shift of a length along a bearing, from +x towards +y [rad]."""
    return length * cos(bearing), length * sin(bearing)


# The fewest props with which a falling build stands after each placement and removal, to the end.
#
# A set of props that suffices still suffices with more props, as no prop needs to carry load. So only falling stages
# are judged again.


@dataclass(frozen=True, slots=True)
class Propping:
    """Permanent supports, one per brick."""

    bricks: tuple[BodyId, ...]
    next_to_fall: tuple[BodyId, ...] = ()  # bricks of a later fall that no props prevent; empty if everything stands


def propping(piling: Piling, on_progress: OnProgress = ignore_progress) -> Propping | None:
    """Return the fewest props with which the whole build stands, or else its first fall; None if none are found.

    `on_progress` is called with the number of verdicts.
    """
    whole = piling.whole()
    parts = Subsets(whole, props_of(whole))
    states = [parts.part_of(there) for there in piling.states()]
    first = next((turn for turn, part in enumerate(states) if not _stands(parts, part)), None)
    if first is None:
        return None
    props = least_props(parts, states[:first:-1] + states[first : first + 1], on_progress)
    if props:
        return Propping(tuple(in_order(props)))
    props = least_props(parts, states[first : first + 1], on_progress)
    if not props:
        return None
    last = next(part for part in states[first:] if not _stands(parts, part))
    fall = parts.ask(last).fall
    return Propping(tuple(in_order(props)), tuple(parts.names_of(fall.moving)) if fall is not None else ())


def _stands(parts: Subsets, part: Part) -> bool:
    return parts.ask(part).stability is Stability.STABLE


# The least shift of one brick, with the bricks on it, with which a build stands; or several such shifts.
#
# A brick is tried at increasing distances along bearings all around. From the nearest stable place the length is
# bisected and the bearing turned to the foot of the perpendicular on the line through two neighbouring limits: limits
# of tipping are straight lines. The result stands, and a shift shorter by a millionth falls. A ring of bearings shows
# that no other bearing needs a much shorter shift; between these bearings this is not proven.


BEARINGS = 16
STEPS = (0.002, 0.01, 0.03, 0.07, 0.15, 0.3, 0.5, 0.75, 1.0)  # times the longest side of the brick
CLOSE = 1e-6  # relative width of the bracket between a failing and a sufficient shift
BEYOND = 0.2  # of that width: distance of a shift that is expected to suffice from the expected limit
MOST_GUESSES = 3  # one after the other, before a bisection: bad ones would approach the limit slowly
TURN = 0.02  # [rad] between two limits that give the direction of the border
LONGER = 1.1  # times the limit at a bearing: the limit beside it is at most this
TURNS = 3
NEAR = 1e-3  # share of a shift by which another one must be shorter to be taken
QUARTERS = (0.0, 0.5 * pi, pi, 1.5 * pi)  # bearings of the axes
NEARLY = 1.2  # times the least shift: a shift along an axis that is at most this long is taken instead
DIGITS = 4  # of a shift as shown to users, if the rounded shift stands
MOST_AT_ONCE = 12  # shifts of bricks together
SIDES = 24  # bearings of the ring
RING = 0.97  # of the shift: this length is shown to be too short along the ring


_Limit: TypeAlias = tuple[float, float, float]  # a failing and a sufficient shift, close to each other, and the bearing


@dataclass(frozen=True, slots=True)
class BrickShift:
    """Shift of a brick with which the build stands, by a verdict."""

    brick: BodyId
    shift: Shift  # parallel to the ground [m]
    too_little: float  # [m] along the same bearing, proven to fall
    shorter: int = 0  # number of bearings of the ring along which a slightly shorter shift is proven to fall

    @property
    def length(self) -> float:
        """Return the length in plan [m]."""
        return hypot(*self.shift)


@dataclass(frozen=True, slots=True)
class SeveralShifts:
    """Shifts with which the build stands if all are applied."""

    shifts: Sequence[tuple[BodyId, Shift]]
    too_little: float  # share of all shifts with which the build is proven to fall


class Shifting:
    """Falling build and the effect of shifts on it."""

    def __init__(self, piling: Piling, on_verdict: Callable[[], None] = lambda: None) -> None:
        """Store the build; `on_verdict` is called after each verdict."""
        self.piling = piling
        self.carried = piling.carried()
        self.verdict_count = 0
        self._build = ShiftedBuild(piling)
        self._on_verdict = on_verdict
        self._lengths = {placed.brick.id: placed.brick.shape.length for placed in piling.bricks}

    def stands(self, shifts: Mapping[BodyId, Shift], upto: int | None = None) -> bool | None:
        """Return whether the build stands with these bricks and their load moved; None if undecided or impossible."""
        self.verdict_count += 1
        self._on_verdict()
        sums = self._sums(shifts)
        ways = {name: self.piling.way(shift) for name, shift in sums.items()}
        if any(self._build.crowds(self.carried[brick], ways) for brick in shifts):
            return None
        end = len(self.piling.stages)
        if self._build.falls_again(ways, end if upto is None else upto - 1):
            return False
        moved = self.piling.shifted(sums)
        if upto is None:  # cheap, and decides most other trials
            verdict = moved.verdict_at_once()
            if verdict.stability is Stability.UNSTABLE:
                self._build.add_fall(end, ways, verdict.motion)
                return False
        fall = moved.first_fall(upto)
        if fall is None:
            return True
        if fall[1].stability is not Stability.UNSTABLE:
            return None
        self._build.add_fall(fall[0], ways, fall[1].motion)
        return False

    def _sums(self, shifts: Mapping[BodyId, Shift]) -> dict[BodyId, Shift]:
        """Return the shift of each brick, which is carried along by those below."""
        sums: dict[BodyId, Shift] = {}
        for brick, (x, y) in shifts.items():
            for name in self.carried[brick]:
                ox, oy = sums.get(name, (0.0, 0.0))
                sums[name] = ox + x, oy + y
        return sums

    def least(
        self, brick: BodyId, others: Mapping[BodyId, Shift], upto: int | None = None, most: float | None = None
    ) -> BrickShift | None:
        """Return the least shift of a brick besides other shifts, at most `most` [m]; None if none is found."""
        ox, oy = others.get(brick, (0.0, 0.0))

        def holds(length: float, bearing: float) -> bool | None:
            x, y = bearing_shift(length, bearing)
            return self.stands({**others, brick: (ox + x, oy + y)}, upto)

        def end(bearing: float) -> float:
            return self._build.end_of_fall(self.carried[brick], self.piling.way(bearing_shift(1.0, bearing)))

        bearings = [2.0 * pi * turn / BEARINGS for turn in range(BEARINGS)]
        fails = dict.fromkeys(bearings, 0.0)
        for step in STEPS:
            length = step * self._lengths[brick]
            if most is not None and fails and min(fails.values()) > most:
                break
            answers = {bearing: holds(length, bearing) for bearing in bearings}
            if any(answers.values()):
                sufficient = [bearing for bearing, answer in answers.items() if answer]
                best = self._turned(self._narrowed(fails, length, sufficient, holds, end), holds, end)
                # Along a side it is longer, but one number tells where to move the brick.
                sides = [quarter for quarter in QUARTERS if holds(NEARLY * best[1], quarter)]
                ring = sum(holds(RING * best[1], 2.0 * pi * turn / SIDES) is False for turn in range(SIDES))
                if sides:
                    best = self._narrowed(dict.fromkeys(sides, 0.0), NEARLY * best[1], sides, holds, end)
                else:
                    best = self._shortened(best, holds, end)
                low, high, bearing = best
                shift = bearing_shift(high, bearing)
                longer = _longer(shift)
                held = hypot(*longer) <= self._lengths[brick] and self.stands(
                    {**others, brick: (ox + longer[0], oy + longer[1])}, upto
                )
                return BrickShift(brick, longer if held else shift, low, ring)
            fails.update({bearing: length for bearing, answer in answers.items() if answer is False})
        return None

    @staticmethod
    def _narrowed(
        fails: dict[float, float],
        held: float,
        bearings: Sequence[float],
        holds: Callable[[float, float], bool | None],
        end: Callable[[float], float] = lambda _: inf,
    ) -> _Limit:
        """Return the least sufficient shift along some bearings, close to a failing one, and its bearing.

        `fails` has the longest failing shift of each bearing. `end` returns by how much a fall along a bearing, just
        proven, would continue. Only the bearings that hold where another one holds are searched further.
        """
        # the least shift that is known to be too short, by a fall or by another body in the way
        low, guess, guesses = min(fails[bearing] for bearing in bearings), inf, 0
        while held - low > 0.5 * CLOSE * held:
            is_guess = low < guess < held and guesses < MOST_GUESSES
            guesses = guesses + 1 if is_guess else 0
            middle = guess if is_guess else 0.5 * (low + held)
            holding, guess = [], inf
            for bearing in bearings:
                answer = holds(middle, bearing)
                if answer:
                    holding.append(bearing)
                elif answer is False:
                    fails[bearing] = middle
                    guess = min(guess, middle + end(bearing) + BEYOND * CLOSE * middle)
            if holding:
                held, bearings, guess = middle, holding, middle * (1.0 - 2.0 * BEYOND * CLOSE) if is_guess else inf
            else:
                low = middle
        return fails[bearings[0]], held, bearings[0]

    def _turned(
        self, best: _Limit, holds: Callable[[float, float], bool | None], end: Callable[[float], float]
    ) -> _Limit:
        """Return the same for a better bearing, if there is one nearby."""
        for _ in range(TURNS):
            _, length, bearing = best
            beside = next((turn for turn in (bearing + TURN, bearing - TURN) if holds(LONGER * length, turn)), None)
            if beside is None:
                break
            other = self._narrowed({beside: 0.0}, LONGER * length, [beside], holds, end)
            turned = _foot(bearing_shift(length, bearing), bearing_shift(*other[1:]))
            if not holds(length, turned):
                best = min(best, other, key=lambda each: each[1])
                break
            tried = self._narrowed({turned: 0.0}, length, [turned], holds, end)
            if tried[1] > length * (1.0 - CLOSE):
                break
            best = tried
        return best

    def _shortened(
        self, best: _Limit, holds: Callable[[float, float], bool | None], end: Callable[[float], float]
    ) -> _Limit:
        """Return the same for a shift whose parts along the axes are as short as each alone can be.

        Over a corner, two limits meet, and the shortest shift is at right angles to neither.
        """

        def at(shift: Shift) -> bool | None:
            return holds(hypot(*shift), atan2(shift[1], shift[0]))

        def least_share(at_share: Callable[[float], Shift]) -> float:
            if at(at_share(0.0)):
                return 0.0
            return self._narrowed({0.0: 0.0}, 1.0, [0.0], lambda share, _: at(at_share(share)))[1]

        _, held, bearing = best
        x, y = bearing_shift(held, bearing)
        shorter = (least_share(lambda share: (share * x, y)) * x, y), (x, least_share(lambda share: (x, share * y)) * y)
        shortest = min(shorter, key=lambda each: hypot(*each))
        length, turned = hypot(*shortest), atan2(shortest[1], shortest[0])
        if length > held * (1.0 - NEAR) or not holds(length, turned):
            return best
        return self._narrowed({turned: 0.0}, length, [turned], holds, end)

    def candidates(self, turn: int, verdict: Verdict) -> list[BodyId]:
        """Return the bricks whose shift could change a fall at a stage: moving ones, neighbours, bricks above."""
        whole, there = self.piling.whole(), self.piling.there(turn)
        moving = set(verdict.moving)
        near = moving | {b for name in moving for c in whole.contacts(name) for b in (c.lower, c.upper)}
        return in_order([name for name in self.carried if name in there and self.carried[name] & near & there])

    def several(self) -> SeveralShifts | None:
        """Return shifts that each repair the first remaining fall with the least length; None if a fall has none."""
        shifts: dict[BodyId, Shift] = {}
        for _ in range(MOST_AT_ONCE):
            fall = self._first_fall(shifts)
            if fall is None:
                return self._shrunk(shifts)
            turn, verdict = fall
            best: BrickShift | None = None
            for brick in self.candidates(turn, verdict):
                candidate = self.least(brick, shifts, turn + 1, best.length if best else None)
                if candidate is not None and (best is None or candidate.length < best.length):
                    best = candidate
            if best is None:
                return None
            x, y = shifts.get(best.brick, (0.0, 0.0))
            shifts[best.brick] = x + best.shift[0], y + best.shift[1]
        return None

    def _first_fall(self, shifts: Mapping[BodyId, Shift]) -> tuple[int, Verdict] | None:
        return self.piling.shifted(self._sums(shifts)).first_fall()

    def _shrunk(self, shifts: Mapping[BodyId, Shift]) -> SeveralShifts | None:
        """Return the necessary ones of some shifts, reduced by the same factor as far as the build stands."""
        needed = dict(shifts)
        for brick in list(needed):
            fewer = {name: shift for name, shift in needed.items() if name != brick}
            if fewer and self.stands(fewer):
                needed = fewer
        if not self.stands(needed):
            return None

        def holds(share: float, _: float) -> bool | None:
            return self.stands({name: (share * x, share * y) for name, (x, y) in needed.items()})

        low, high, _ = self._narrowed({0.0: 0.0}, 1.0, [0.0], holds)
        least = {name: (high * x, high * y) for name, (x, y) in needed.items()}
        longer = {name: _longer(shift) for name, shift in least.items()}
        return SeveralShifts(list((longer if self.stands(longer) else least).items()), low / high)


def _foot(one: Shift, other: Shift) -> float:
    """Return the bearing of the foot of the perpendicular on the line through two shifts [rad]."""
    dx, dy = other[0] - one[0], other[1] - one[1]
    across = one[0] * dy - one[1] * dx
    return atan2(-across * dx, across * dy)


def rounded_up(length: float) -> float:
    """Return the next larger number with few digits [m]."""
    unit = 10.0 ** (floor(log10(length)) + 1 - DIGITS)
    return float(f"{unit * ceil(length / unit * (1.0 - CLOSE * CLOSE)):.{DIGITS}g}")


def _longer(shift: Shift) -> Shift:
    """Return a shift whose parts along the axes are the next longer numbers with few digits."""
    x, y = (copysign(rounded_up(abs(part)), part) if abs(part) > EXACT * hypot(*shift) else 0.0 for part in shift)
    return x, y
