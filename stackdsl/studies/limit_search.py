"""Searches for a limit by bracketing and bisection, with one verdict per number."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from math import inf
from typing import Final, TypeAlias

from stability.problem import Stability
from stackdsl.diagnostics import Diagnostic
from stackdsl.judging.proofs import proofs_of
from stackdsl.judging.remedies import BracketTolerance, narrow_bracket
from stackdsl.timeline import Timeline

# Verdicts of a scenario with another number, each computed once.


LARGE: Final = 250  # bricks: above, and above four times the written number, a build is tried only in a given range

Compiled: TypeAlias = Callable[[float], tuple[Timeline | None, Sequence[Diagnostic]]]


class SearchError(ValueError):
    """The scenario has no number of this name, or the number has no limit that can be searched for."""


class TrialVerdict(StrEnum):
    """The verdict of one number."""

    STANDS = "stands"  # proven for each step of the build that statics can judge
    FALLS = "falls"  # proven by a checked motion
    OPEN = "undecided"
    NO_SCENARIO = "is invalid"
    TOO_LARGE = "is not tried"  # too many bricks


ANSWERS: Final = {
    Stability.STABLE: TrialVerdict.STANDS,
    Stability.UNSTABLE: TrialVerdict.FALLS,
    Stability.UNDECIDED: TrialVerdict.OPEN,
}


@dataclass(frozen=True, slots=True)
class Tried:
    """One number and its verdict."""

    value: float
    answer: TrialVerdict
    why: str = ""  # the motion of the fall, the reason of doubt, or the error that makes the scenario invalid
    timeline: Timeline | None = None
    judged: int = 0  # number of judged bricks
    bricks: int = 0  # number of bricks
    moment: float = 0.0  # time of the placement at which it falls [s]

    @property
    def shape(self) -> object:
        """The planes and the placed bricks; a number that leaves them equal has no effect."""
        if self.timeline is None:
            return None
        return self.timeline.final_world, [
            (each.brick, each.pose) for each in self.timeline.placements if not each.hits
        ]


@dataclass
class VerdictCache:
    """Computes and caches verdicts by number."""

    compiled: Compiled
    largest: float = inf  # most bricks of a build that is judged
    on_trial: Callable[[int], None] = lambda _: None  # called with the number of trials so far
    tried: dict[float, Tried] = field(default_factory=dict)

    @property
    def verdicts(self) -> int:
        """Number of verdicts of statics."""
        return sum(each.timeline is not None for each in self.tried.values())

    def __call__(self, value: float) -> Tried:
        """Return the trial of a number."""
        if value not in self.tried:
            self.tried[value] = self._try(value)
            self.on_trial(len(self.tried))
        return self.tried[value]

    def holds(self, value: float) -> bool | None:
        """Return whether the build stands with a number; None if that is undecided."""
        answer = self(value).answer
        return answer is TrialVerdict.STANDS if answer in (TrialVerdict.STANDS, TrialVerdict.FALLS) else None

    def _try(self, value: float) -> Tried:
        timeline, diagnostics = self.compiled(value)
        if timeline is None:
            why = next((f"{each.code}: {each.message}" for each in diagnostics), "")
            return Tried(value, TrialVerdict.NO_SCENARIO, why)
        bricks = sum(not each.hits for each in timeline.placements)
        if bricks > self.largest:
            return Tried(value, TrialVerdict.TOO_LARGE, f"the scenario has {bricks} bricks")
        proofs = proofs_of(timeline, names_smallest=False)
        verdict = proofs.assembly.verdict()
        judged = sum(len(each.bricks) for each in proofs.judged)
        when = timeline.as_set_down().actions[max(0, proofs.done - 1)].time
        return Tried(value, ANSWERS[verdict.stability], verdict.reason, timeline, judged, bricks, when)


def short_reason(tried: Tried) -> str:
    """Return the reason of a verdict; for a fall, with the smallest set of bricks that begin it."""
    if tried.timeline is None or tried.answer is not TrialVerdict.FALLS:
        return tried.why
    return proofs_of(tried.timeline).verdict.reason or tried.why


# The largest or the least number with which a scenario stands: stepped to from the written one, then bisected.
#
# Both sides of the result were tried: statics prove that one stands and the other falls. Between trials the verdict may
# change more than once, so a few more numbers are tried on both sides, and contradicting ones are reported.


SHARES: Final = (0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 0.95, 1.0, *(2.0**power for power in range(1, 11)))
WHOLE: Final = tuple(2.0**power for power in range(13))  # steps away from a whole number
EVENLY: Final = 12  # parts of a given range
BESIDE: Final = (0.25, 0.5, 0.75)  # of the number: distances from the limit at which its sides are checked
GUESSED: Final = (0.45, 4.0, 40.0)  # of the accuracy: distances from a guess that are tried
NOTHING: Final = 1e-9  # of the written number: a limit so close to zero counts as zero


@dataclass(frozen=True, slots=True)
class Range:
    """Range of numbers to try."""

    low: float = -inf
    high: float = inf
    given: bool = False  # whether the user gave the range, rather than the domain of the number

    def takes(self, value: float) -> bool:
        """Return whether a number lies in the range."""
        return self.low <= value <= self.high


@dataclass(frozen=True, slots=True)
class SearchStart:
    """The start of a search."""

    number: float
    size: float  # a typical size of such numbers, used if `number` is zero
    whole: bool


EVERYWHERE: Final = Range()


@dataclass(frozen=True, slots=True)
class SearchTarget:
    """The target of a search."""

    upwards: bool  # whether the largest number is searched, rather than the least
    accuracy: float  # relative distance between both sides of the limit
    range: Range = EVERYWHERE
    guess: float | None = None  # the expected limit, if known

    @property
    def sign(self) -> float:
        """The direction from numbers that stand to the limit."""
        return 1.0 if self.upwards else -1.0


@dataclass(frozen=True, slots=True)
class SearchResult:
    """The result of a search."""

    stands: Tried | None  # the last number that stands; None if none tried does
    beyond: Tried | None = None  # the first number that does not; None if all do up to the end
    guessed: bool = False  # whether the guess was right, so that only its two sides were tried
    is_open: bool = False  # whether numbers between the two are undecided
    contradicting: Sequence[Tried] = ()  # trials with another verdict than the rest of their side


def search(trials: VerdictCache, start: SearchStart, target: SearchTarget) -> SearchResult:
    """Search for the largest or the least number that stands."""
    return _Search(trials, start, target).run()


@dataclass(frozen=True, slots=True)
class _Search:
    trials: VerdictCache
    start: SearchStart
    target: SearchTarget

    def run(self) -> SearchResult:
        guessed = self._guessed(self.target.guess) if self.target.guess is not None else None
        result = guessed or self._stepped()
        if result.stands is None or result.beyond is None or result.beyond.answer is TrialVerdict.TOO_LARGE:
            return result
        self._try_beside(result.stands.value, result.beyond.value)
        contradicting = self._contradicting(result)
        return SearchResult(result.stands, result.beyond, guessed is not None, result.is_open, contradicting)

    def _guessed(self, guess: float) -> SearchResult | None:
        """Return the limit if it is at the guess; further trials around it if verdicts close to it are undecided."""
        for share in GUESSED:
            near = share * self.target.accuracy * abs(guess)
            values = (guess - self.target.sign * near, guess + self.target.sign * near)
            if not near or not all(map(self.target.range.takes, values)):
                return None
            inside, outside = map(self.trials, values)
            if inside.answer is TrialVerdict.STANDS and outside.answer is TrialVerdict.FALLS:
                return SearchResult(inside, outside) if share < 1.0 else self._narrowed(inside, outside)
        return None

    def _stepped(self) -> SearchResult:
        """Return the limit, by steps away from the written number."""
        first = self.trials(min(max(self.start.number, self.target.range.low), self.target.range.high))
        if first.answer is TrialVerdict.STANDS:
            return self._outwards(first)
        stands, before = self._first_that_stands(first, -self.target.sign)
        if stands is None:
            stands, _ = self._first_that_stands(first, self.target.sign)
            return SearchResult(None) if stands is None else self._outwards(stands)
        return self._narrowed(stands, before) if before is not None else self._outwards(stands)

    def _first_that_stands(self, first: Tried, sign: float) -> tuple[Tried | None, Tried | None]:
        """Step away from a number that does not stand; return the first that stands and the last that falls."""
        before = first if first.answer is TrialVerdict.FALLS else None
        for value in self._values(first.value, sign):
            tried = self.trials(value)
            if tried.answer is TrialVerdict.STANDS:
                return tried, before
            if tried.answer is TrialVerdict.FALLS:
                before = tried
            if tried.answer is TrialVerdict.TOO_LARGE:
                break
        return None, before

    def _outwards(self, stands: Tried) -> SearchResult:
        """Return the limit, by steps outwards from a number that stands."""
        for value in self._values(stands.value, self.target.sign):
            tried = self.trials(value)
            if tried.answer is TrialVerdict.FALLS:
                return self._narrowed(stands, tried)
            if tried.answer is TrialVerdict.NO_SCENARIO:
                return self._to_the_edge(stands, tried)
            if tried.answer is TrialVerdict.TOO_LARGE:
                return SearchResult(stands, tried)
            stands = tried if tried.answer is TrialVerdict.STANDS else stands
        return SearchResult(stands)

    def _to_the_edge(self, stands: Tried, none: Tried) -> SearchResult:
        """Return the limit before the scenario becomes invalid, or else the edge of validity."""
        closeness = self._closeness()
        while not closeness.is_of(stands.value, none.value):
            tried = self.trials(closeness.middle(stands.value, none.value))
            stands, none = (tried, none) if tried.answer is TrialVerdict.STANDS else (stands, tried)
        return SearchResult(stands, none)

    def _narrowed(self, stands: Tried, falls: Tried) -> SearchResult:
        bracket = narrow_bracket(stands.value, falls.value, self._closeness(), self.trials.holds)
        return SearchResult(self.trials(bracket.holds), self.trials(bracket.fails), is_open=bracket.is_open)

    def _closeness(self) -> BracketTolerance:
        nothing = NOTHING * (abs(self.start.number) or self.start.size)
        return BracketTolerance(self.target.accuracy, self.start.whole, nothing)

    def _values(self, start: float, sign: float) -> Iterator[float]:
        """Yield the numbers to try, away from the first, up to the end of the range."""
        size = abs(self.start.number) or self.start.size
        end = self.target.range.high if sign > 0.0 else self.target.range.low
        values = {start + sign * (step if self.start.whole else step * size) for step in self._steps()}
        if self.start.whole and start > 1.0 > sign:
            values.add(1.0)
        if self.target.range.given and abs(end) < inf:
            values |= {start + (end - start) * part / EVENLY for part in range(1, EVENLY)}
        if abs(end) < inf:
            values.add(end)
        if self.start.whole:
            values = {float(round(value)) for value in values}
        yield from sorted((each for each in values - {start} if self.target.range.takes(each)), key=lambda v: sign * v)

    def _steps(self) -> Sequence[float]:
        return WHOLE if self.start.whole else SHARES

    def _try_beside(self, stands: float, beyond: float) -> None:
        """Try a few more numbers on either side of the limit."""
        size = abs(stands) or abs(self.start.number) or self.start.size
        for share in BESIDE:
            for value in (stands - self.target.sign * share * size, beyond + self.target.sign * share * size):
                beside = float(round(value)) if self.start.whole else value
                if self.target.range.takes(beside):
                    self.trials(beside)

    def _contradicting(self, result: SearchResult) -> Sequence[Tried]:
        """Return the trials that fall before the limit or stand beyond it."""
        assert result.stands is not None
        limit = self.target.sign * result.stands.value
        return [
            each
            for value, each in sorted(self.trials.tried.items())
            if each.answer is (TrialVerdict.FALLS if self.target.sign * value < limit else TrialVerdict.STANDS)
            and value != result.stands.value
        ]
