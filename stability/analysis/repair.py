"""Searches for repairs of a build that falls: shifts of bricks in plan, and props."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import atan2, ceil, copysign, cos, floor, hypot, inf, log10, pi, sin
from typing import TypeAlias

from stability.analysis.building_order import least_props
from stability.analysis.subset_search import OnProgress, Part, Subsets, ignore_progress, props_of
from stability.contact_law import GivenFriction
from stability.geometry.box_distance import gap_bridged, reach_between
from stability.geometry.placed_shape import apart, apart_from_plane
from stability.geometry.vectors import add, add_scaled, cross, unit
from stability.model import GROUND, BodyId, Plane, Vec3
from stability.name_order import in_order
from stability.problem import UP, Placed, Stability, Tolerances, Verdict
from stability.statics.assembly import Assembly

# A build whose bricks may be shifted in plan: which of it stands with given shifts.
#
# A shifted brick carries the bricks on it along. Shifts are parallel to the ground, or horizontal without ground.


EXACT = 1e-4  # share of the contact distance: bodies this near lie on each other, within rounding

Shift: TypeAlias = tuple[float, float]  # parallel to the ground, towards +x and +y [m]


@dataclass(frozen=True, slots=True)
class Piling:
    """Build: groups of bricks placed together in order, fixed bodies, and removals."""

    planes: Sequence[Plane]
    friction: GivenFriction
    gravity: float
    stages: Sequence[Sequence[Placed]]
    pulled: Mapping[int, Sequence[BodyId]] = field(default_factory=dict)  # by the number of the next stage
    tolerances: Tolerances = Tolerances()  # noqa: RUF009 -- frozen

    @property
    def bricks(self) -> list[Placed]:
        """Return all bricks of all stages."""
        return [placed for stage in self.stages for placed in stage]

    def states(self) -> Iterator[frozenset[BodyId]]:
        """Yield the present bricks after each placement or removal."""
        there: frozenset[BodyId] = frozenset()
        for turn, stage in enumerate(self.stages):
            if turn in self.pulled:
                there -= frozenset(self.pulled[turn])
                yield there
            if stage:
                there |= {placed.brick.id for placed in stage}
                yield there

    def there(self, turn: int) -> frozenset[BodyId]:
        """Return the bricks present at a stage."""
        removed = {name for before, names in self.pulled.items() if before <= turn for name in names}
        return frozenset(placed.brick.id for stage in self.stages[: turn + 1] for placed in stage) - removed

    def carried(self) -> dict[BodyId, frozenset[BodyId]]:
        """Return each brick with all bricks that rest on it."""
        whole = self.whole()
        return {name: frozenset(whole.with_all_above([name])) for name in whole.bricks}

    def whole(self) -> Assembly:
        """Return an assembly of all bricks of all stages."""
        whole = self.assembly()
        whole.add_all(self.bricks, names_smallest=False)
        return whole

    def assembly(self) -> Assembly:
        """Return an assembly of the fixed bodies only."""
        return Assembly(self.planes, self.friction, self.gravity, self.tolerances, overlap=inf)

    def shifted(self, shifts: Mapping[BodyId, Shift]) -> "Piling":
        """Return the same build with each brick moved by the sum of its shifts."""
        along, across = self._axes()

        def moved(placed: Placed) -> Placed:
            if placed.brick.id not in shifts:
                return placed
            x, y = shifts[placed.brick.id]
            position = add_scaled(add_scaled(placed.pose.position_W, x, along), y, across)
            return replace(placed, pose=replace(placed.pose, position_W=position))

        return replace(self, stages=[[moved(placed) for placed in stage] for stage in self.stages])

    def way(self, shift: Shift) -> Vec3:
        """Return a shift as a vector in W [m]."""
        along, across = self._axes()
        return add(add_scaled((0.0, 0.0, 0.0), shift[0], along), add_scaled((0.0, 0.0, 0.0), shift[1], across))

    def _axes(self) -> tuple[Vec3, Vec3]:
        normal = next((plane.normal_W for plane in self.planes if plane.id == GROUND), UP)
        across = unit(cross(normal, (1.0, 0.0, 0.0)))
        return cross(across, normal), across

    def falls_at_once(self) -> bool:
        """Return whether the final bricks, placed together, are proven to fall.

        Then the build falls at the last stage or before.
        """
        assembly = self.assembly()
        removed = {name for names in self.pulled.values() for name in names}
        last = [placed for placed in self.bricks if placed.brick.id not in removed]
        return assembly.add_all(last, names_smallest=False).stability is Stability.UNSTABLE

    def first_fall(self, upto: int | None = None, *, names_smallest: bool = False) -> tuple[int, Verdict] | None:
        """Return the first of `upto` stages at which not all bricks stand, and its verdict; None if all stand.

        With `names_smallest` the verdict names the smallest falling set that is found, which takes seconds for a heap.
        """
        assembly = self.assembly()
        for turn, stage in enumerate(self.stages[:upto]):
            if turn in self.pulled:
                verdict = assembly.remove(self.pulled[turn], names_smallest=names_smallest)
                if verdict.stability is not Stability.STABLE:
                    return turn, verdict
            if stage:
                verdict = assembly.add_all(stage, names_smallest=names_smallest)
                if verdict.stability is not Stability.STABLE:
                    return turn, verdict
        return None

    def touching(self) -> frozenset[tuple[BodyId, BodyId]]:
        """Return all touching pairs, the lower body first."""
        return frozenset((contact.lower, contact.upper) for contact in self.whole().all_contacts())

    def crowds(self, moved: frozenset[BodyId], touching: frozenset[tuple[BodyId, BodyId]]) -> bool:
        """Return whether a moved brick overlaps another body or grazes one that it did not touch before.

        A grazing contact counts as contact and might be the only support of the brick.
        """
        moving = [placed for placed in self.bricks if placed.brick.id in moved]
        others = [placed for placed in self.bricks if placed.brick.id not in moved]
        times = self._times()

        def meet(one: Placed, other: Placed) -> bool:
            (come, go), (other_come, other_go) = times[one.brick.id], times[other.brick.id]
            return come < other_go and other_come < go

        return any(meet(a, b) and self._crowds(a, b, touching) for a in moving for b in others) or any(
            apart_from_plane(one.brick.shape, one.pose, plane).gap < -reach_between(one.brick.shape.least_thickness)
            for one in moving
            for plane in self.planes
        )

    def _times(self) -> dict[BodyId, tuple[int, int]]:
        """Return the stage at which each brick is placed, and the stage before which it is removed."""
        removal_of = {name: turn for turn, names in self.pulled.items() for name in names}
        return {
            placed.brick.id: (turn, removal_of.get(placed.brick.id, len(self.stages)))
            for turn, stage in enumerate(self.stages)
            for placed in stage
        }

    def _crowds(self, one: Placed, other: Placed, touching: frozenset[tuple[BodyId, BodyId]]) -> bool:
        reach = one.brick.shape.bounding_radius + other.brick.shape.bounding_radius
        near = zip(one.pose.position_W, other.pose.position_W, strict=True)
        if any(abs(a - b) > reach for a, b in near):
            return False
        deep = reach_between(one.brick.shape.least_thickness, other.brick.shape.least_thickness)
        between = apart(one.brick.shape, one.pose, other.brick.shape, other.pose)
        bridged = gap_bridged(deep, between.normal_BA_W[2], self.tolerances.within)  # less beside a brick than below it
        pairs = {(one.brick.id, other.brick.id), (other.brick.id, one.brick.id)}
        grazes = abs(between.gap) > EXACT * deep and between.gap <= bridged
        return between.gap < -deep or (grazes and not pairs & touching)


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
        self.touching = piling.touching()
        self.verdict_count = 0
        self._on_verdict = on_verdict
        self._lengths = {placed.brick.id: placed.brick.shape.length for placed in piling.bricks}

    def stands(self, shifts: Mapping[BodyId, Shift], upto: int | None = None) -> bool | None:
        """Return whether the build stands with these bricks and their load moved; None if undecided or impossible."""
        self.verdict_count += 1
        self._on_verdict()
        sums: dict[BodyId, Shift] = {}
        for brick, (x, y) in shifts.items():
            for name in self.carried[brick]:
                ox, oy = sums.get(name, (0.0, 0.0))
                sums[name] = ox + x, oy + y
        moved = self.piling.shifted(sums)
        if any(moved.crowds(self.carried[brick], self.touching) for brick in shifts):
            return None
        if upto is None and moved.falls_at_once():  # cheap, and decides most trials
            return False
        fall = moved.first_fall(upto)
        if fall is None:
            return True
        return False if fall[1].stability is Stability.UNSTABLE else None

    def least(
        self, brick: BodyId, others: Mapping[BodyId, Shift], upto: int | None = None, most: float | None = None
    ) -> BrickShift | None:
        """Return the least shift of a brick besides other shifts, at most `most` [m]; None if none is found."""
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
            halved = []
            for bearing in bearings:
                held = holds(length, bearing)
                if held:
                    halved.append(self._halved(fails[bearing], length, bearing, holds))
                elif held is False:
                    fails[bearing] = length
            if halved:
                low, high, bearing = self._turned(min(halved, key=lambda each: each[1]), holds)
                # Along a side it is longer, but one number tells where to move the brick.
                sides = [quarter for quarter in QUARTERS if holds(NEARLY * high, quarter)]
                along = [self._halved(0.0, NEARLY * high, quarter, holds) for quarter in sides]
                ring = sum(holds(RING * high, 2.0 * pi * turn / SIDES) is False for turn in range(SIDES))
                if along:
                    low, high, bearing = min(along, key=lambda each: each[1])
                else:
                    low, high, bearing = self._shortened(low, high, bearing, holds)
                shift = bearing_shift(high, bearing)
                longer = _longer(shift)
                held = hypot(*longer) <= self._lengths[brick] and self.stands(
                    {**others, brick: (ox + longer[0], oy + longer[1])}, upto
                )
                return BrickShift(brick, longer if held else shift, low, ring)
        return None

    @staticmethod
    def _halved(
        fails: float, held: float, bearing: float, holds: Callable[[float, float], bool | None]
    ) -> tuple[float, float, float]:
        """Return a failing and a sufficient shift along a bearing, close to each other, and the bearing."""
        low = fails  # the least shift known to be too short, by a fall or by another body in the way
        while held - low > 0.5 * CLOSE * held:
            middle = 0.5 * (low + held)
            answer = holds(middle, bearing)
            if answer:
                held = middle
            else:
                low = middle
                fails = middle if answer is False else fails
        return fails, held, bearing

    def _turned(
        self, best: tuple[float, float, float], holds: Callable[[float, float], bool | None]
    ) -> tuple[float, float, float]:
        """Return the same for a better bearing, if there is one nearby."""
        for _ in range(TURNS):
            _, length, bearing = best
            beside = next((turn for turn in (bearing + TURN, bearing - TURN) if holds(LONGER * length, turn)), None)
            if beside is None:
                break
            other = self._halved(0.0, LONGER * length, beside, holds)
            turned = _foot(bearing_shift(length, bearing), bearing_shift(*other[1:]))
            if not holds(length, turned):
                best = min(best, other, key=lambda each: each[1])
                break
            tried = self._halved(0.0, length, turned, holds)
            if tried[1] > length * (1.0 - CLOSE):
                break
            best = tried
        return best

    def _shortened(
        self, fails: float, held: float, bearing: float, holds: Callable[[float, float], bool | None]
    ) -> tuple[float, float, float]:
        """Return the same for a shift whose parts along the axes are as short as each alone can be.

        Over a corner, two limits meet, and the shortest shift is at right angles to neither.
        """

        def at(shift: Shift) -> bool | None:
            return holds(hypot(*shift), atan2(shift[1], shift[0]))

        x, y = bearing_shift(held, bearing)
        shorter_x = self._halved(0.0, 1.0, 0.0, lambda share, _: at((share * x, y)))[1]
        shorter_y = self._halved(0.0, 1.0, 0.0, lambda share, _: at((x, share * y)))[1]
        best = min(((shorter_x * x, y), (x, shorter_y * y)), key=lambda each: hypot(*each))
        length, turned = hypot(*best), atan2(best[1], best[0])
        if length > held * (1.0 - NEAR) or not holds(length, turned):
            return fails, held, bearing
        return self._halved(0.0, length, turned, holds)

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
        sums: dict[BodyId, Shift] = {}
        for brick, (x, y) in shifts.items():
            for name in self.carried[brick]:
                ox, oy = sums.get(name, (0.0, 0.0))
                sums[name] = ox + x, oy + y
        return self.piling.shifted(sums).first_fall()

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

        low, high, _ = self._halved(0.0, 1.0, 0.0, holds)
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
