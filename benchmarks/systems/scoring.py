"""Records -> scores: how far each run is from what is known, or from what the finest runs agree on.

Of a run that falls where it should stand, or stands where it should fall, nothing but that and its level is told: where
debris lies is no measure of anything.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from benchmarks.systems.answers import Answer, Source
from benchmarks.systems.entrants import REFERENCES
from benchmarks.systems.run_record import Record, step_text
from stackdsl.results import KINDS, Change, Seen, changes, turned_back
from stackdsl.trace import NUMERICAL_COLLAPSE, UNRELIABLE, RunVerdict

# What is compared with a converged reference. The rest is creep, or chaos, as is the height of what a fall leaves.
COMPARED_FALLEN = ("collapse time", "reach", "bearing")
LOOKS_APART = 0.0105  # [s] between two looks of a run, and a little
# Kinds of truth that are scored as verdicts, and the one that is scored as creep, unless something is hit: then how far
# it goes is a length as any other.
OF_VERDICTS, OF_CREEP = {"stands", "collapses", "verdict"}, "drift"
COMPARED_STANDING = ("height",)  # where something was dropped, thrown or pushed; what is still has its own height


@dataclass(frozen=True, slots=True)
class Reference:
    """What the finest runs of a bare engine agree on."""

    system: str
    factor: float  # of the finest
    observations: Mapping[str, Seen]

    @property
    def answer(self) -> Answer:
        """Its verdict, as an answer."""
        level = self.observations.get("collapse level")
        if self.observations["verdict"] != RunVerdict.COLLAPSES:
            return Answer(True, Source.CONVERGED)
        return Answer(False, Source.CONVERGED, *((level, level) if isinstance(level, float) else ()))


@dataclass(frozen=True, slots=True)
class Score:
    """One run against what is known; None where that is not known, or where there is no such measure."""

    record: Record
    verdict: str = ""  # as the run has it, or `numerical-collapse`
    known: Source | None = None
    wrong: bool | None = None
    levels: float | None = None
    mm: float | None = None
    deg: float | None = None
    seconds: float | None = None
    creep: float | None = None  # largest shift of anything while nothing should move [mm]
    energy: float | None = None  # gain after the last action [%]


def scores_of(records: Iterable[Record], answers: Mapping[str, Answer | None]) -> list[Score]:
    """The score of each record, in order; `answers` by case."""
    by_case: defaultdict[str, list[Record]] = defaultdict(list)
    records = list(records)
    for record in records:
        by_case[record.case].append(record)
    references = {case: reference_of(own, answers[case]) for case, own in by_case.items()}
    return [_score(record, by_case[record.case], answers[record.case], references[record.case]) for record in records]


def reference_of(records: Sequence[Record], answer: Answer | None) -> Reference | None:
    """What the two finest runs of the first bare engine agree on, if they do on the verdict, and with what is known."""
    for system in REFERENCES:
        finest = sorted((r for r in records if r.system == system), key=lambda record: record.factor)[:2]
        agreed = _agreed(finest)
        if agreed is None:
            continue
        reference = Reference(system, finest[0].factor, agreed)
        if answer is None or reference.answer.stands == answer.stands:
            return reference
    return None


def _agreed(finest: Sequence[Record]) -> Mapping[str, Seen] | None:
    match finest:
        case [Record(observations={"verdict": verdict}), *_] if verdict == UNRELIABLE:
            return None
        case [Record(observations=dict() as fine), Record(observations=dict() as coarser)]:
            moved = {change.name for change in changes(coarser, fine) if change.moved or _still_converges(change)}
            return None if "verdict" in moved else {kind: seen for kind, seen in fine.items() if kind not in moved}
        case _:
            return None


def _still_converges(change: Change) -> bool:
    """Whether two runs see a fall at times further apart than two looks: solvers begin falls early, by many steps."""
    return change.name == "collapse time" and change.difference is not None and abs(change.difference) > LOOKS_APART


def _score(record: Record, fellows: Sequence[Record], answer: Answer | None, reference: Reference | None) -> Score:
    if record.observations is None:
        return Score(record)
    known = answer or (reference.answer if reference is not None else None)
    verdict = _verdict(record, fellows, known)
    score = Score(record, verdict, energy=record.seen("energy gain"))
    if known is None:
        return score
    fell = record.seen("collapse level")
    unfounded = bool(record.numerical) or verdict == UNRELIABLE  # right for no reason is not right
    wrong = known.stands is (fell is not None) or unfounded
    score = replace(
        score,
        known=known.source,
        wrong=wrong,
        levels=known.levels_off(fell, record.levels),
        creep=_creep(record, known),
    )
    if wrong:
        return score
    compared = [] if reference is None or known.still else _differences(record, reference, known)
    fell_after = record.seen("collapse time")
    if fell_after is not None and known.timed:
        compared.append(("s", known.seconds_off(fell_after)))
    return replace(
        score,
        mm=_furthest(record, compared, "mm", known.undisturbed),
        deg=_furthest(record, compared, "deg", known.undisturbed),
        seconds=_furthest(record, compared, "s", known.undisturbed),
    )


def _creep(record: Record, known: Answer) -> float | None:
    """How far anything moved in a structure that should stand, or in one that should fall, before it was set down."""
    if not known.undisturbed:
        return None
    return record.seen("drift" if known.stands else "shift before")


def _verdict(record: Record, fellows: Sequence[Record], known: Answer | None) -> str:
    """The run's verdict; a collapse that the next finer time step lets stand is numerical, unless it should fall."""
    assert record.observations is not None
    own = str(record.observations["verdict"])
    finer = [f for f in fellows if f.system == record.system and f.factor < record.factor and f.done]
    next_finer = max(finer, key=lambda fellow: fellow.factor, default=None)
    if own != RunVerdict.COLLAPSES or next_finer is None or (known is not None and not known.stands):
        return own
    return NUMERICAL_COLLAPSE if next_finer.seen("collapse level") is None else own


def numerical_reason(score: Score) -> str:
    """Why a collapse is called numerical."""
    return score.record.numerical or f"it stands at a finer time step than {step_text(score.record.factor)}"


def _furthest(record: Record, compared: Sequence[tuple[str, float]], unit: str, undisturbed: bool) -> float | None:
    """The largest distance of this unit from truths and from the reference."""
    apart = {*OF_VERDICTS, OF_CREEP} if undisturbed else OF_VERDICTS
    truths = [truth for truth in record.truths if truth.kind not in apart]
    off = [truth.off for truth in truths if truth.unit == unit]
    off += [difference for own, difference in compared if own == unit]
    return max((value for value in off if value is not None), default=None)


def _differences(record: Record, reference: Reference, known: Answer) -> list[tuple[str, float]]:
    """Each unit and distance from the reference, where nothing better is known; a run has none from itself."""
    if (record.system, record.factor) == (reference.system, reference.factor):
        return []
    kinds = COMPARED_STANDING if record.seen("collapse level") is None else COMPARED_FALLEN
    found = [
        (kind, _difference(kind, record.seen(kind), reference.observations.get(kind)))
        for kind in kinds
        if kind != "collapse time" or not known.timed
    ]
    return [(KINDS[kind].unit, difference) for kind, difference in found if difference is not None]


def _difference(kind: str, seen: float | None, true: Seen) -> float | None:
    if seen is None or not isinstance(true, float):
        return None
    off = abs(turned_back(seen - true) if KINDS[kind].unit == "deg" else seen - true)
    return max(0.0, off - LOOKS_APART) if kind == "collapse time" else off  # both are seen at the next look
