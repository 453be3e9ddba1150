"""A bench as text: all runs, the wrong results, then one row per point, for the choice of a system."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence

from benchmarks.systems.bench import Bench
from benchmarks.systems.points import COMPARED_WITH, MEASURES, Point, fronts_of
from benchmarks.systems.run_record import step_text
from benchmarks.systems.scoring import Score, numerical_reason
from stackdsl.report.blocks import Block, Row, blocks_text, line, table, titled
from stackdsl.trace import NUMERICAL_COLLAPSE
from stackdsl.wording import significant

NOTHING = "-"
LEFT = ("case", "system", "step", "verdict", "known", "front")
MEBIBYTE = 2.0**20


def bench_text(bench: Bench, width: int = 160, colour: bool = False) -> str:
    """Return the whole text."""
    return blocks_text([*filter(None, _blocks(bench)), [line(closing_line(bench))]], width, colour)


def closing_line(bench: Bench) -> str:
    """Return a summary of the finished runs."""
    done = sum(score.record.done for score in bench.scores)
    wrong = sum(bool(score.wrong) for score in bench.scores)
    numerical = sum(score.verdict == NUMERICAL_COLLAPSE for score in bench.scores)
    wrong_verdicts = "1 wrong verdict" if wrong == 1 else f"{wrong} wrong verdicts"
    collapses = "1 numerical collapse" if numerical == 1 else f"{numerical} numerical collapses"
    left = sum(not score.record.taken for score in bench.scores)
    not_taken_too = f", {left} not taken" if left else ""
    told = f"{done} of {bench.wanted} runs done{not_taken_too}, {wrong_verdicts}, {collapses}"
    return told + ("; interrupted" if bench.interrupted else "")


def _blocks(bench: Bench) -> Iterator[Block]:
    yield [table([run_row(score) for score in bench.scores], LEFT)] if bench.scores else []
    yield titled("Not taken", not_taken(bench.scores))
    yield titled("Did not finish", [_stopped(s) for s in bench.scores if s.record.taken and not s.record.done])
    yield titled("Wrong verdicts", [_wrong(score) for score in bench.scores if score.wrong])
    yield titled("Numerical collapses", [_numerical(s) for s in bench.scores if s.verdict == NUMERICAL_COLLAPSE])
    yield [table(point_rows(bench.points), LEFT)] if bench.points else []


def run_row(score: Score) -> Row:
    """Return the row of one run."""
    record = score.record
    return {
        "case": record.case,
        "system": record.system,
        "step": step_text(record.factor),
        "verdict": score.verdict or record.status,
        "known": (score.known.value if score.known is not None else NOTHING) + (", wrong" if score.wrong else ""),
        "levels": number(score.levels),
        "creep mm": number(score.creep),
        "mm": number(score.mm),
        "deg": number(score.deg),
        "s": number(score.seconds),
        "energy %": number(score.energy),
        "wall s": number(record.wall_time) if record.done else NOTHING,
        "sim. s": f"{record.simulated_time:.1f}" if record.done else NOTHING,
        "steps": str(record.steps) if record.done else NOTHING,
        "solves": str(record.solves) if record.done else NOTHING,
        "MiB": f"{record.peak_memory / MEBIBYTE:.0f}" if record.done else NOTHING,
        "update ms": milliseconds(record.update_median),
        "worst ms": milliseconds(record.update_worst),
    }


def point_rows(points: Sequence[Point]) -> list[Row]:
    """Return one row per point; `front` names the measures in which no other point is both faster and more accurate."""
    fronts = fronts_of(points)
    return [_point_row(point, [measure for measure, front in fronts.items() if point in front]) for point in points]


def _point_row(point: Point, fronts: Iterable[str]) -> Row:
    return {
        "system": point.system,
        "step": step_text(point.factor),
        "runs": f"{point.done}/{point.runs}",
        "wrong": f"{point.wrong_verdicts}/{point.known}",
        "numerical": str(point.numerical),
        "levels": number(point.errors["levels"]),
        "creep mm": number(point.errors["creep"]),
        "mm": number(point.errors["mm"]),
        "deg": number(point.errors["deg"]),
        "s": number(point.errors["seconds"]),
        "energy %": number(point.energy),
        "wall s / sim. s": number(point.pace),
        f"x {COMPARED_WITH}": number(point.times_exact),
        "wall s": number(point.wall_time),
        "sim. s": f"{point.simulated_time:.1f}",
        "steps": str(point.steps),
        "solves": str(point.solves),
        "MiB": f"{point.peak_memory / MEBIBYTE:.0f}",
        "update ms": milliseconds(point.update_median),
        "worst ms": milliseconds(point.update_worst),
        "front": ", ".join(measure for measure in MEASURES if measure in fronts) or NOTHING,
    }


def not_taken(scores: Iterable[Score]) -> list[str]:
    """Return a line for each participant and reason of unsupported cases; one reason for several is one line."""
    cases: defaultdict[tuple[str, str], list[str]] = defaultdict(list)
    for score in scores:
        if not score.record.taken:
            cases[score.record.system, score.record.message].append(score.record.case)
    systems: defaultdict[tuple[str, tuple[str, ...]], list[str]] = defaultdict(list)
    for (system, why), names in cases.items():
        systems[why, tuple(names)].append(system)
    found = [(" and ".join(same), len(names), why, names) for (why, names), same in systems.items()]
    return [f"{who} ({count}): {why}: {', '.join(names)}" for who, count, why, names in found]


def number(value: float | None) -> str:
    """Return a number with three digits; empty if unknown."""
    return NOTHING if value is None else significant(value)


def milliseconds(seconds: float | None) -> str:
    """Return a short time with three digits."""
    return number(None if seconds is None else 1000.0 * seconds)


def _stopped(score: Score) -> str:
    return f"{score.record.name}: {score.record.status}: {score.record.message}"


def _wrong(score: Score) -> str:
    fell = score.record.seen("collapse level")
    what = "stands" if fell is None else f"falls at level {fell:g}"
    return f"{score.record.name}: {what}, known from {score.known}"


def _numerical(score: Score) -> str:
    return f"{score.record.name}: {numerical_reason(score)}"
