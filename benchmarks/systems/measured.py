"""A bench as data of docs: points and runs, and the long table of the recorded runs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from statistics import geometric_mean

from benchmarks.figures.columns import Column, Table
from benchmarks.figures.data import Data, Row, Rows, measured_now
from benchmarks.figures.markdown import table_text
from benchmarks.systems.answers import Answer
from benchmarks.systems.bench import Bench
from benchmarks.systems.points import COMPARED_WITH, Point, fronts_of, pace_of
from benchmarks.systems.run_record import Record, step_text
from benchmarks.systems.scoring import Score
from stackdsl.trace import NUMERICAL_COLLAPSE

NAME, COMMAND = "speed-against-error", "make bench"
CASES = f"{NAME}-cases"
PICTURE = f"{NAME}.svg"
MEBIBYTE = 2.0**20
OWN_STEP = (1.0, 0.0)  # of a system, and of an assessor without steps
ASSESSORS = ("cra", "rbe")
SHOWN = tuple(
    f"{case}, {assessor}"
    for case in ("hard-far-four-stack", "slant-tower", "slant-tower-flush")
    for assessor in ASSESSORS
)  # runs in tables of pages; all other runs are in the file of cases only
ERRORS = {"levels": "levels", "creep": "creep_mm", "mm": "length_mm", "deg": "angle_deg", "seconds": "time_s"}


def data_of(bench: Bench) -> tuple[Data, Data]:
    """Return the points, and the runs at the systems' own steps."""
    own = [score for score in bench.scores if score.record.factor in OWN_STEP and score.record.taken]
    paces = {score.record.case: pace_of(score.record) for score in own if score.record.system == COMPARED_WITH}
    cases = {
        f"{_named(score.record.case)}, {score.record.system}": _run(score, paces.get(score.record.case), bench.answers)
        for score in own
    }
    fronts = fronts_of(bench.points)
    tables = {
        "points": {_named(point.name): _point(point, fronts) for point in bench.points},
        "systems": by_system(bench.points),
        "assessors": assessors(cases),
        "bench": {"whole": _whole(bench)},
        "shown": {name: run for name, run in cases.items() if name in SHOWN},
    }
    made_with = dict(sorted(bench.versions.items()))
    return (
        replace(measured_now(NAME, COMMAND, tables), versions=made_with),
        replace(measured_now(CASES, COMMAND, {"runs": cases}), versions=made_with),
    )


def _named(name: str) -> str:
    """Return a name without the slashes of units and steps, which separate the parts of figure paths."""
    return name.replace(" / ", " : ").replace("/", " per ")


def _whole(bench: Bench) -> Row:
    return {
        "wanted": bench.wanted,
        "done": sum(score.record.done for score in bench.scores),
        "not_taken": sum(not score.record.taken for score in bench.scores),
        "wrong": sum(bool(score.wrong) for score in bench.scores),
        "numerical": sum(score.verdict == NUMERICAL_COLLAPSE for score in bench.scores),
        "cases": len({score.record.case for score in bench.scores}),
    }


def _point(point: Point, fronts: Mapping[str, Sequence[Point]]) -> Row:
    return {
        "system": point.system,
        "step": step_text(point.factor),
        "runs": point.runs,
        "done": point.done,
        "known": point.known,
        "wrong": point.wrong_verdicts,
        "numerical": point.numerical,
        **{key: point.errors[measure] for measure, key in ERRORS.items()},
        "energy_percent": point.energy,
        "pace": point.pace,
        "times_exact": point.times_exact,
        "wall_s": point.wall_time,
        "simulated_s": point.simulated_time,
        "steps": point.steps,
        "solves": point.solves,
        "memory_mib": point.peak_memory / MEBIBYTE,
        **_updates(point),
        "front": ", ".join(sorted(measure for measure, front in fronts.items() if point in front)),
    }


def _updates(told: Point | Record) -> Row:
    """Return the times of one update of the extension [ms]."""
    taken = {"update_median_ms": told.update_median, "update_worst_ms": told.update_worst}
    return {key: None if seconds is None else 1000.0 * seconds for key, seconds in taken.items()}


def by_system(points: Sequence[Point]) -> Rows:
    """Return each system at its own step, by its plain name."""
    return {
        point.system: {"known": point.known, "wrong": point.wrong_verdicts, "times_exact": point.times_exact}
        for point in points
        if point.factor in OWN_STEP
    }


def _run(score: Score, exact: float | None, answers: Mapping[str, Answer | None]) -> Row:
    record, answer = score.record, answers[score.record.case]
    pace = pace_of(record) if record.done else None
    return {
        "case": record.case,
        "system": record.system,
        "known": "" if answer is None else f"{'stands' if answer.stands else 'falls'}, {answer.source}",
        "verdict": score.verdict or record.status,
        "wrong": score.wrong,
        "falls_at": record.seen("collapse level"),
        "levels": score.levels,
        "creep_mm": score.creep,
        "length_mm": score.mm,
        "angle_deg": score.deg,
        "time_s": score.seconds,
        "wall_s": record.wall_time if record.done else None,
        "steps": record.steps if record.done else None,
        "solves": record.solves if record.done else None,
        "memory_mib": record.peak_memory / MEBIBYTE if record.done else None,
        **_updates(record),
        "times_exact": pace / exact if pace and exact else None,
    }


def assessors(cases: Rows) -> Rows:
    """Return the times of the assessors relative to `exact` for cases that both judge correctly, by outcome."""
    found: dict[str, Row] = {}
    for program in ASSESSORS:
        rows = [row for row in cases.values() if row["system"] == program]
        found[program] = {"taken": len(rows), "wrong": sum(bool(row["wrong"]) for row in rows)}
        for verdict in ("stands", "falls"):
            times = [float(row["times_exact"] or 0.0) for row in rows if _right(row, verdict) and row["times_exact"]]
            if times:
                found[f"{program} {verdict}"] = {
                    "mean": geometric_mean(times),
                    "least": min(times),
                    "most": max(times),
                }
    return found


def _right(row: Row, verdict: str) -> bool:
    return not row["wrong"] and str(row["known"]).startswith(verdict)


RUN_TABLE = Table(
    CASES,
    "runs",
    (
        Column("system", "{system}"),
        Column("verdict", "{verdict}"),
        Column("wrong", "{wrong}"),
        Column("falls at level", "{falls_at:g}"),
        Column("levels", "{levels:sig3}"),
        Column("creep mm", "{creep_mm:sig3}"),
        Column("mm", "{length_mm:sig3}"),
        Column("deg", "{angle_deg:sig3}"),
        Column("s", "{time_s:sig3}"),
        Column("wall s", "{wall_s:sig3}"),
        Column("x exact", "{times_exact:sig3}"),
        Column("steps", "{steps}"),
        Column("solves", "{solves}"),
        Column("MiB", "{memory_mib:.0f}"),
        Column("update ms", "{update_median_ms:sig2}"),
        Column("worst ms", "{update_worst_ms:sig2}"),
    ),
)


def cases_text(data: Data) -> Iterator[str]:
    """Yield the long table, case by case, as Markdown."""
    rows = data.tables["runs"]
    for case in dict.fromkeys(str(row["case"]) for row in rows.values()):
        own = {name: row for name, row in rows.items() if row["case"] == case}
        known = next(iter(own.values()))["known"]
        yield f"\n### {case}{f': {known}' if known else ''}\n\n"
        yield table_text(RUN_TABLE, lambda _, own=own: Data(CASES, COMMAND, {"runs": own}))  # type: ignore[misc]
