"""The largest or the least number with which a scenario stands, of one case.

What is asked is what `check --statics` asks: whether the build stands at each of its steps, as far as statics can
judge. Nothing is played, so what something hits, or a hand holds, is judged up to that moment.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import atan, degrees, inf
from typing import Final

from stability.statics.facts import Motion, Problem, Stability
from stability.statics.margins.acceleration import acceleration
from stability.statics.margins.bearings import along_bearings
from stability.statics.solvers.fall_words import described
from stackdsl.checking.gathering import Case
from stackdsl.finding.asking import LARGE, Answer, Asking, Tried, told_shortly
from stackdsl.finding.search import Aim, Found, Range, search
from stackdsl.finding.sought import Sought, SoughtError, is_shaken, sought_of
from stackdsl.judging.proofs import proofs_of

ACCURACY: Final = 1e-7  # how far the sides of a limit may be apart, relative to it
FINEST: Final = 1e-9  # what verdicts are sure of
SHAKEN_UNITS: Final = {"tilt": "deg", "acceleration": "g"}


class Want(StrEnum):
    """Which number is asked for."""

    LARGEST = "largest"
    LEAST = "least"
    MOST = "most"  # the largest whole number


class End(StrEnum):
    """What a limit was found to be, or why there is none."""

    LIMIT = "limit"  # it stands on one side, and falls on the other
    EDGE = "edge"  # it stands up to the last number with which it is a scenario
    NONE = "no limit"  # it stands with all that were tried on that side
    NOWHERE = "nowhere"  # it falls with all that were tried
    OPEN = "undecided"  # it is proven to stand with none that was tried, and some are undecided
    NO_EFFECT = "no effect"  # the same is built with every number
    NOTHING = "nothing"  # there is nothing that statics can judge


@dataclass(frozen=True, slots=True)
class FoundLimit:
    """What was found of one number of one case."""

    case: str
    want: Want
    name: str
    unit: str  # of all numbers here; empty for none
    written: float | None  # the number of the scenario; None where it has none
    end: End
    stands: float | None = None  # proven to stand; None if none is, inf if everything stands
    beyond: float | None = None  # proven to fall; at an edge, no scenario; None if it stands to the end of the search
    scale: float = 1.0  # SI units in one of the unit
    low: float = 0.0  # the least and the largest number that were tried
    high: float = 0.0
    why: str = ""  # what gives way beyond the limit, and how; or why no number is beyond
    by_program: bool = False  # whether a conic program told where, rather than halving
    verdicts: int = 0  # of statics that were asked
    is_open: bool = False  # whether numbers between the two sides could not be judged
    contradicting: Sequence[tuple[float, str]] = ()  # numbers with which it is other than on their side, and how
    judged: int = 0  # bricks that statics judged
    bricks: int = 0  # bricks that are built
    place: str = ""  # where the number is written
    others: str = ""  # what stays as it is, or goes with it
    moment: float | None = None  # when that is set down with which it falls [s]


@dataclass(frozen=True, slots=True)
class Wish:
    """What is asked for."""

    want: Want
    name: str
    low: str = ""  # as an author writes it; empty: as far as is searched
    high: str = ""
    accuracy: float = ACCURACY
    bearing: float | None = None  # downhill [rad], of a tilt or an acceleration; None: the worst


def find_in(case: Case, name: str, wish: Wish, told: Callable[[int], None] = lambda _: None) -> FoundLimit:
    """The limit of one case that is called `name`; `told` hears how many numbers were tried. Raises SoughtError."""
    if wish.want is not Want.MOST and is_shaken(case, wish.name):
        return _shaken(case, name, wish)
    if wish.bearing is not None:
        raise SoughtError("a bearing is asked of the tilt or the acceleration of what is finished")
    sought = sought_of(case, wish.name, wish.want is not Want.LEAST)
    within = _range(sought, wish)
    built = len(case.timeline.placements)
    asking = Asking(sought.compiled, inf if within.given else max(LARGE, 4 * built), told)
    whole = _is_whole(sought, wish, asking)
    guess = None if whole else sought.guess()
    found = search(asking, sought.start(whole), Aim(wish.want is not Want.LEAST, wish.accuracy, within, guess))
    _refuse_what_was_never_a_scenario(sought, asking)
    return _finding(name, wish, sought, found, asking)


def _refuse_what_was_never_a_scenario(sought: Sought, asking: Asking) -> None:
    if not asking.verdicts:
        first = next(iter(asking.tried.values()))
        why = f"with {sought.text(first.value)}, {first.why}"
        raise SoughtError(f"it is no scenario with any number that was tried; {why}")


def _range(sought: Sought, wish: Wish) -> Range:
    low, high = (sought.value(text) if text else None for text in (wish.low, wish.high))
    least, most = sought.domain.low, sought.domain.high
    low, high = (least if low is None else max(low, least)), (most if high is None else min(high, most))
    if low >= high:
        raise SoughtError(f"from {sought.text(low)} to {sought.text(high)} there is nothing to search")
    return Range(low, high, given=bool(wish.low or wish.high))


def _is_whole(sought: Sought, wish: Wish, asking: Asking) -> bool:
    """Whether whole numbers are tried: those that look whole, and can be nothing else."""
    if wish.want is Want.MOST:
        if not sought.is_whole:
            raise SoughtError(f"'{sought.name}' is {sought.text(sought.number)}: ask for the --largest, not the --most")
        return True
    return sought.is_whole and asking(sought.number + 0.5).answer is Answer.NO_SCENARIO


# --- what came of it --------------------------------------------------------------------------------------------------


def _finding(name: str, wish: Wish, sought: Sought, found: Found, asking: Asking) -> FoundLimit:
    stands, beyond = found.stands, found.beyond
    end = _end(found, asking)
    tried = sorted(value for value, each in asking.tried.items() if each.answer not in _NOT_TRIED)
    shown = stands or next(iter(asking.tried.values()))
    return FoundLimit(
        name,
        wish.want,
        sought.name,
        sought.unit,
        sought.number,
        end,
        stands.value if stands is not None else None,
        beyond.value if beyond is not None and end in (End.LIMIT, End.EDGE) else None,
        sought.scale,
        tried[0] if tried else sought.number,
        tried[-1] if tried else sought.number,
        _why(end, beyond, asking),
        found.guessed,
        asking.verdicts,
        found.is_open,
        tuple((each.value, each.answer.value) for each in found.contradicting),
        shown.judged,
        shown.bricks,
        sought.place,
        sought.others,
        beyond.moment if beyond is not None and beyond.answer is Answer.FALLS else None,
    )


_NOT_TRIED: Final = (Answer.NO_SCENARIO, Answer.TOO_LARGE)


def _end(found: Found, asking: Asking) -> End:
    built = [each for each in asking.tried.values() if each.timeline is not None]
    if built and not any(each.judged for each in built):
        return End.NOTHING
    if found.beyond is not None and found.beyond.answer is Answer.FALLS:
        return End.LIMIT
    if len(built) > 1 and all(each.shape == built[0].shape for each in built):
        return End.NO_EFFECT
    if found.stands is None:
        is_open = any(each.answer is Answer.OPEN for each in built)
        return End.OPEN if is_open else End.NOWHERE
    return End.EDGE if found.beyond is not None and found.beyond.answer is not Answer.TOO_LARGE else End.NONE


def _why(end: End, beyond: Tried | None, asking: Asking) -> str:
    if beyond is not None:
        return told_shortly(beyond) if end is End.LIMIT else beyond.why
    if end in (End.NOWHERE, End.OPEN):
        answer = Answer.OPEN if end is End.OPEN else Answer.FALLS
        return next((told_shortly(each) for each in asking.tried.values() if each.answer is answer), "")
    return ""


# --- what is finished, as a whole -------------------------------------------------------------------------------------


def _shaken(case: Case, name: str, wish: Wish) -> FoundLimit:
    """How far the finished structure may be tilted, or accelerated: forces prove it, and a motion that no more."""
    if wish.want is Want.LEAST:
        raise SoughtError(f"what is finished stands from no {wish.name} on: ask for the --largest")
    if wish.low or wish.high:
        raise SoughtError(f"a program tells the {wish.name} of what is finished: leave out --from and --to")
    proofs = proofs_of(case.timeline)
    assembly, unit = proofs.assembly, SHAKEN_UNITS[wish.name]
    bricks = sum(not each.hits for each in case.timeline.placements)
    judged = sum(len(each.bricks) for each in proofs.judged)
    nothing = FoundLimit(name, wish.want, wish.name, unit, None, End.NOTHING, judged=judged, bricks=bricks)
    if not assembly.bricks:
        return nothing
    if assembly.verdict().stability is not Stability.STABLE:
        return FoundLimit(
            name,
            wish.want,
            wish.name,
            unit,
            None,
            End.NOWHERE,
            why=proofs.verdict.reason,
            bricks=bricks,
            verdicts=1,
        )
    limit = _limit(assembly.problem(), wish, assembly.gravity)
    if limit is None:
        return nothing
    stands, falls, motion = limit
    turned = (lambda share: degrees(atan(share))) if wish.name == "tilt" else float
    return FoundLimit(
        name,
        wish.want,
        wish.name,
        unit,
        None,
        End.NONE if stands == inf else End.LIMIT,
        turned(stands),
        None if falls == inf else turned(falls),
        atan(1.0) / 45.0 if wish.name == "tilt" else 1.0,
        high=turned(stands),
        why="" if motion is None else described(assembly.problem(), motion),
        by_program=True,
        verdicts=1,
        is_open=falls < inf
        and falls - stands > 1.01 * wish.accuracy * falls,  # as programs keep to it, but for rounding
        judged=judged,
        bricks=bricks,
    )


def _limit(problem: Problem, wish: Wish, gravity: float) -> tuple[float, float, Motion | None] | None:
    """What is survived, what is not, and how it then moves [g]."""
    if wish.bearing is None:
        worst = acceleration(problem, wish.accuracy, gravity)
        return None if worst is None else (worst.value, worst.upper, worst.motion)
    found = along_bearings(problem, [wish.bearing], wish.accuracy, gravity)
    return None if found is None else (found[0].value, found[0].upper, found[0].motion)
