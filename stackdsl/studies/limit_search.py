"""Brackets and bisects a limit, with one verdict per value."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from math import inf
from typing import Final, TypeAlias

from stability.problem import Stability
from stackdsl.diagnostics import Diagnostic
from stackdsl.judging.proofs import proofs_of
from stackdsl.judging.remedies import BracketTolerance, narrowed
from stackdsl.timeline import Timeline

# What statics say of a scenario with another number in it: asked once a number, and remembered.


LARGE: Final = 250  # bricks: more, and more than four times what is built, are tried only if somebody says how far

Compiled: TypeAlias = Callable[[float], tuple[Timeline | None, Sequence[Diagnostic]]]


class TrialVerdict(StrEnum):
    """What came of one number."""

    STANDS = "stands"  # at each step of building, as far as statics can judge, by proof
    FALLS = "falls"  # likewise, by a motion that was checked
    OPEN = "undecided"
    NO_SCENARIO = "is no scenario"
    TOO_LARGE = "is not tried"  # as it has so many bricks


ANSWERS: Final = {
    Stability.STABLE: TrialVerdict.STANDS,
    Stability.UNSTABLE: TrialVerdict.FALLS,
    Stability.UNDECIDED: TrialVerdict.OPEN,
}


@dataclass(frozen=True, slots=True)
class Tried:
    """One number, and what came of it."""

    value: float
    answer: TrialVerdict
    why: str = ""  # what moves and how, what is in doubt, or why it is no scenario
    timeline: Timeline | None = None
    judged: int = 0  # bricks that statics judged
    bricks: int = 0  # bricks that are built
    moment: float = 0.0  # when the bricks were set down with which it falls [s]

    @property
    def shape(self) -> object:
        """What is built, and on what; numbers with which that is the same have no effect."""
        if self.timeline is None:
            return None
        return self.timeline.world, [(each.brick, each.pose) for each in self.timeline.placements if not each.hits]


@dataclass
class VerdictCache:
    """Asks, and keeps what came of it."""

    compiled: Compiled
    largest: float = inf  # bricks: what has more is left alone
    told: Callable[[int], None] = lambda _: None  # of how many were asked, as it goes on
    tried: dict[float, Tried] = field(default_factory=dict)

    @property
    def verdicts(self) -> int:
        """How many verdicts were asked of statics."""
        return sum(each.timeline is not None for each in self.tried.values())

    def __call__(self, value: float) -> Tried:
        """What comes of a number."""
        if value not in self.tried:
            self.tried[value] = self._ask(value)
            self.told(len(self.tried))
        return self.tried[value]

    def holds(self, value: float) -> bool | None:
        """Whether it stands; None where that cannot be said."""
        answer = self(value).answer
        return answer is TrialVerdict.STANDS if answer in (TrialVerdict.STANDS, TrialVerdict.FALLS) else None

    def _ask(self, value: float) -> Tried:
        timeline, mistakes = self.compiled(value)
        if timeline is None:
            why = next((f"{each.code}: {each.message}" for each in mistakes), "")
            return Tried(value, TrialVerdict.NO_SCENARIO, why)
        bricks = sum(not each.hits for each in timeline.placements)
        if bricks > self.largest:
            return Tried(value, TrialVerdict.TOO_LARGE, f"it has {bricks} bricks")
        proofs = proofs_of(timeline, names_smallest=False)
        verdict = proofs.assembly.verdict()
        judged = sum(len(each.bricks) for each in proofs.judged)
        when = timeline.as_set_down().actions[max(0, proofs.done - 1)].time
        return Tried(value, ANSWERS[verdict.stability], verdict.reason, timeline, judged, bricks, when)


def told_shortly(tried: Tried) -> str:
    """How what falls begins to."""
    if tried.timeline is None or tried.answer is not TrialVerdict.FALLS:
        return tried.why
    return proofs_of(tried.timeline).verdict.reason or tried.why


# The largest or the least number with which a scenario stands: walked to from the one that is written, then halved.
#
# What is handed out was asked for itself: on one side statics prove that it stands, on the other that it falls. Between
# numbers that were tried it may be otherwise: a few more are asked on both sides, and what contradicts is told.


SHARES: Final = (0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95, 1.0, *(2.0**power for power in range(1, 11)))
WHOLE: Final = tuple(2.0**power for power in range(13))  # how far from a whole number others are tried
EVENLY: Final = 12  # points, where somebody says how far
BESIDE: Final = (0.25, 0.5, 0.75)  # of the number: where it is asked whether all is alike on one side of the limit
GUESSED: Final = (0.45, 4.0, 40.0)  # of the accuracy: how far aside of a guess it is asked
NOTHING: Final = 1e-9  # of the size of the number that is written: a limit that is so close to zero is zero


@dataclass(frozen=True, slots=True)
class Range:
    """Where numbers are tried."""

    low: float = -inf
    high: float = inf
    given: bool = False  # whether somebody said so, rather than that no others are possible

    def takes(self, value: float) -> bool:
        """Whether a number lies in it."""
        return self.low <= value <= self.high


@dataclass(frozen=True, slots=True)
class SearchStart:
    """Where the search begins."""

    number: float
    size: float  # of usual numbers of the kind, where it is zero
    whole: bool


EVERYWHERE: Final = Range()


@dataclass(frozen=True, slots=True)
class SearchTarget:
    """What is searched for."""

    upwards: bool  # whether it is the largest, rather than the least
    accuracy: float  # by which share of it both sides may be apart
    range: Range = EVERYWHERE
    guess: float | None = None  # where it is expected, if somebody knows

    @property
    def sign(self) -> float:
        """The way in which the limit lies from what stands."""
        return 1.0 if self.upwards else -1.0


@dataclass(frozen=True, slots=True)
class SearchResult:
    """What a search came to."""

    stands: Tried | None  # the last with which it stands; None if it stands with none that was tried
    beyond: Tried | None = None  # the first with which it does not; None if it stands up to the end
    guessed: bool = False  # whether it was known from a program, and only asked on both sides
    is_open: bool = False  # whether numbers between could not be judged
    contradicting: Sequence[Tried] = ()  # with which it is other than on the rest of their side


def search(asking: VerdictCache, start: SearchStart, aim: SearchTarget) -> SearchResult:
    """The largest number with which it stands, or the least."""
    return _Search(asking, start, aim).found()


@dataclass(frozen=True, slots=True)
class _Search:
    ask: VerdictCache
    start: SearchStart
    aim: SearchTarget

    def found(self) -> SearchResult:
        known = self._guessed(self.aim.guess) if self.aim.guess is not None else None
        found = known or self._walked()
        if found.stands is None or found.beyond is None or found.beyond.answer is TrialVerdict.TOO_LARGE:
            return found
        self._ask_beside(found.stands.value, found.beyond.value)
        return SearchResult(found.stands, found.beyond, known is not None, found.is_open, self._contradicting(found))

    def _guessed(self, guess: float) -> SearchResult | None:
        """The limit where it is expected, if it is there; so close to it that verdicts are open, from further off."""
        for share in GUESSED:
            near = share * self.aim.accuracy * abs(guess)
            values = (guess - self.aim.sign * near, guess + self.aim.sign * near)
            if not near or not all(map(self.aim.range.takes, values)):
                return None
            inside, outside = map(self.ask, values)
            if inside.answer is TrialVerdict.STANDS and outside.answer is TrialVerdict.FALLS:
                return SearchResult(inside, outside) if share < 1.0 else self._narrowed(inside, outside)
        return None

    def _walked(self) -> SearchResult:
        """The limit, walked to from the number that is written."""
        first = self.ask(min(max(self.start.number, self.aim.range.low), self.aim.range.high))
        if first.answer is TrialVerdict.STANDS:
            return self._outwards(first)
        stands, before = self._first_that_stands(first, -self.aim.sign)
        if stands is None:
            stands, _ = self._first_that_stands(first, self.aim.sign)
            return SearchResult(None) if stands is None else self._outwards(stands)
        return self._narrowed(stands, before) if before is not None else self._outwards(stands)

    def _first_that_stands(self, first: Tried, sign: float) -> tuple[Tried | None, Tried | None]:
        """On the way from one that does not, the first with which it stands, and the last with which it falls."""
        before = first if first.answer is TrialVerdict.FALLS else None
        for value in self._way(first.value, sign):
            tried = self.ask(value)
            if tried.answer is TrialVerdict.STANDS:
                return tried, before
            if tried.answer is TrialVerdict.FALLS:
                before = tried
            if tried.answer is TrialVerdict.TOO_LARGE:
                break
        return None, before

    def _outwards(self, stands: Tried) -> SearchResult:
        """The limit on the way on from one that stands."""
        for value in self._way(stands.value, self.aim.sign):
            tried = self.ask(value)
            if tried.answer is TrialVerdict.FALLS:
                return self._narrowed(stands, tried)
            if tried.answer is TrialVerdict.NO_SCENARIO:
                return self._to_the_edge(stands, tried)
            if tried.answer is TrialVerdict.TOO_LARGE:
                return SearchResult(stands, tried)
            stands = tried if tried.answer is TrialVerdict.STANDS else stands
        return SearchResult(stands)

    def _to_the_edge(self, stands: Tried, none: Tried) -> SearchResult:
        """The limit before what can be written, or else that."""
        closeness = self._closeness()
        while not closeness.is_of(stands.value, none.value):
            tried = self.ask(closeness.middle(stands.value, none.value))
            stands, none = (tried, none) if tried.answer is TrialVerdict.STANDS else (stands, tried)
        return SearchResult(stands, none)

    def _narrowed(self, stands: Tried, falls: Tried) -> SearchResult:
        found = narrowed(stands.value, falls.value, self._closeness(), self.ask.holds)
        return SearchResult(self.ask(found.holds), self.ask(found.fails), is_open=found.is_open)

    def _closeness(self) -> BracketTolerance:
        nothing = NOTHING * (abs(self.start.number) or self.start.size)
        return BracketTolerance(self.aim.accuracy, self.start.whole, nothing)

    def _way(self, start: float, sign: float) -> Iterator[float]:
        """The numbers that are tried one after the other, away from the first, to the end of the range."""
        size = abs(self.start.number) or self.start.size
        end = self.aim.range.high if sign > 0.0 else self.aim.range.low
        values = {start + sign * (step if self.start.whole else step * size) for step in self._steps()}
        if self.start.whole and start > 1.0 > sign:
            values.add(1.0)
        if self.aim.range.given and abs(end) < inf:
            values |= {start + (end - start) * part / EVENLY for part in range(1, EVENLY)}
        if abs(end) < inf:
            values.add(end)
        if self.start.whole:
            values = {float(round(value)) for value in values}
        yield from sorted((each for each in values - {start} if self.aim.range.takes(each)), key=lambda v: sign * v)

    def _steps(self) -> Sequence[float]:
        return WHOLE if self.start.whole else SHARES

    def _ask_beside(self, stands: float, beyond: float) -> None:
        """Ask a few numbers more on either side of the limit."""
        size = abs(stands) or abs(self.start.number) or self.start.size
        for share in BESIDE:
            for value in (stands - self.aim.sign * share * size, beyond + self.aim.sign * share * size):
                beside = float(round(value)) if self.start.whole else value
                if self.aim.range.takes(beside):
                    self.ask(beside)

    def _contradicting(self, found: SearchResult) -> Sequence[Tried]:
        """What falls before the limit, or stands beyond it."""
        assert found.stands is not None
        limit = self.aim.sign * found.stands.value
        return [
            each
            for value, each in sorted(self.ask.tried.items())
            if each.answer is (TrialVerdict.FALLS if self.aim.sign * value < limit else TrialVerdict.STANDS)
            and value != found.stands.value
        ]
