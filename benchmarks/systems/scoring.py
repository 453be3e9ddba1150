"""Records -> scores: the error of each run relative to known results, or to the agreement of the finest runs.

A run with a wrong verdict gets only its verdict and level as errors: positions of debris measure nothing.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from benchmarks.systems.answers import Answer, Source
from benchmarks.systems.entrants import REFERENCES
from benchmarks.systems.run_record import Record, step_text
from stackdsl.results import KINDS, Change, Seen, changes, turned_back
from stackdsl.trace import NUMERICAL_COLLAPSE, UNRELIABLE, RunVerdict

# Observations compared with a converged reference. The others are creep, or chaotic, as is the height of fallen bricks.
COMPARED_FALLEN = ("collapse time", "reach", "bearing")
LOOKS_APART = 0.0105  # [s] slightly more than the time between two samples of a run
# Kinds of truth that are scored as verdicts, and the one that is scored as creep, unless something is hit: then a
# displacement counts as a length.
OF_VERDICTS, OF_CREEP = {"stands", "collapses", "verdict"}, "drift"
COMPARED_STANDING = ("height",)  # only if something was dropped, thrown or pushed; a structure at rest keeps its height


@dataclass(frozen=True, slots=True)
class Reference:
    """Agreement of the finest runs of a bare engine."""

    system: str
    factor: float  # of the finest run
    observations: Mapping[str, Seen]

    @property
    def answer(self) -> Answer:
        """Return its verdict as an answer."""
        level = self.observations.get("collapse level")
        if self.observations["verdict"] != RunVerdict.COLLAPSES:
            return Answer(True, Source.CONVERGED)
        return Answer(False, Source.CONVERGED, *((level, level) if isinstance(level, float) else ()))


@dataclass(frozen=True, slots=True)
class Score:
    """Errors of one run; None if unknown, or without such a measure."""

    record: Record
    verdict: str = ""  # of the run, or `numerical-collapse`
    known: Source | None = None
    wrong: bool | None = None
    levels: float | None = None
    mm: float | None = None
    deg: float | None = None
    seconds: float | None = None
    creep: float | None = None  # largest shift of any brick while nothing should move [mm]
    energy: float | None = None  # gain after the last action [%]


def scores_of(records: Iterable[Record], answers: Mapping[str, Answer | None]) -> list[Score]:
    """Return the score of each record, in order; `answers` by case."""
    by_case: defaultdict[str, list[Record]] = defaultdict(list)
    records = list(records)
    for record in records:
        by_case[record.case].append(record)
    references = {case: reference_of(own, answers[case]) for case, own in by_case.items()}
    return [_score(record, by_case[record.case], answers[record.case], references[record.case]) for record in records]


def reference_of(records: Sequence[Record], answer: Answer | None) -> Reference | None:
    """Return the agreement of the two finest runs of the first bare engine.

    None if their verdicts differ or are wrong.
    """
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
    """Return whether two runs differ in the time of a fall by more than two samples.

    Solvers start falls early, by many steps.
    """
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
    # a correct verdict without a valid reason does not count
    unfounded = bool(record.numerical) or verdict == UNRELIABLE
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
    """Return the creep of a structure that should stand, or before the placement at which it should fall."""
    if not known.undisturbed:
        return None
    return record.seen("drift" if known.stands else "shift before")


def _verdict(record: Record, fellows: Sequence[Record], known: Answer | None) -> str:
    """Return the verdict of a run; a wrong collapse that does not occur at the next finer time step is numerical."""
    assert record.observations is not None
    own = str(record.observations["verdict"])
    finer = [f for f in fellows if f.system == record.system and f.factor < record.factor and f.done]
    next_finer = max(finer, key=lambda fellow: fellow.factor, default=None)
    if own != RunVerdict.COLLAPSES or next_finer is None or (known is not None and not known.stands):
        return own
    return NUMERICAL_COLLAPSE if next_finer.seen("collapse level") is None else own


def numerical_reason(score: Score) -> str:
    """Return why a collapse counts as numerical."""
    return score.record.numerical or f"it stands at a finer time step than {step_text(score.record.factor)}"


def _furthest(record: Record, compared: Sequence[tuple[str, float]], unit: str, undisturbed: bool) -> float | None:
    """Return the largest error in this unit, relative to truths and to the reference."""
    apart = {*OF_VERDICTS, OF_CREEP} if undisturbed else OF_VERDICTS
    truths = [truth for truth in record.truths if truth.kind not in apart]
    off = [truth.off for truth in truths if truth.unit == unit]
    off += [difference for own, difference in compared if own == unit]
    return max((value for value in off if value is not None), default=None)


def _differences(record: Record, reference: Reference, known: Answer) -> list[tuple[str, float]]:
    """Return units and differences from the reference for data without a better known result.

    The reference itself has none.
    """
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
    return max(0.0, off - LOOKS_APART) if kind == "collapse time" else off  # both are detected at the next sample
