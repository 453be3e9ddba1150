"""What `make bench` found -> docs/data/speed-against-error.json, its picture, and the figures of the texts.

Run it with `python -m benchmarks.speed_against_error bench`, the directory that `stackdsl bench` wrote to. With
`--cases` it prints the long table, case by case, as it was kept.
"""

import argparse
import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import geometric_mean
from typing import Any

from rich.console import Console
from rich.markdown import Markdown

from benchmarks.figures.columns import Column, Table
from benchmarks.figures.data import Data, Row, Rows, load, measured_now, save
from benchmarks.figures.markdown import table_text
from benchmarks.figures.pages import ROOT, render
from stackdsl.bench.points import COMPARED_WITH
from stackdsl.bench.run_record import NOT_TAKEN, step_text

NAME, COMMAND = "speed-against-error", "make bench"
CASES = f"{NAME}-cases"
PICTURE = f"{NAME}.svg"
MEBIBYTE = 2.0**20
OWN_STEP = (1.0, 0.0)  # of a system; of an assessor, which takes none
ASSESSORS = ("cra", "rbe")
ERRORS = {"levels": "levels", "creep": "creep_mm", "mm": "length_mm", "deg": "angle_deg", "seconds": "time_s"}


def main() -> None:
    """Take over a bench, or print what is kept of the last one."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("folder", nargs="?", type=Path, default=ROOT / "bench", help="where `stackdsl bench` wrote")
    arguments.add_argument("--cases", action="store_true", help="print the kept runs, case by case, and take over none")
    chosen = arguments.parse_args()
    if chosen.cases:
        Console().print(Markdown("".join(cases_text(load(CASES)))))
        return
    bench = json.loads((chosen.folder / "bench.json").read_text(encoding="utf-8"))
    for data in taken_over(bench):
        save(data)
    if (picture := chosen.folder / PICTURE).exists():
        shutil.copyfile(picture, ROOT / "docs" / PICTURE)
    render()


def taken_over(bench: Mapping[str, Any]) -> tuple[Data, Data]:
    """The points, and the runs at the systems' own steps; both of one bench."""
    runs = [run for run in bench["runs"] if run["factor"] in OWN_STEP and run["status"] != NOT_TAKEN]
    paces = {run["case"]: _pace(run) for run in runs if run["system"] == COMPARED_WITH}
    cases = {f"{_named(run['case'])}, {run['system']}": _run(run, paces.get(run["case"]), bench) for run in runs}
    points = {_named(point["name"]): _point(point, bench["fronts"]) for point in bench["points"]}
    whole = {"whole": _whole(bench)}
    tables = {"points": points, "systems": by_system(bench["points"]), "assessors": assessors(cases), "bench": whole}
    versions = bench["versions"]
    return (
        _with_versions(measured_now(NAME, COMMAND, tables), versions),
        _with_versions(measured_now(CASES, COMMAND, {"runs": cases}), versions),
    )


def _with_versions(data: Data, versions: Mapping[str, str]) -> Data:
    return Data(data.name, data.command, data.tables, data.day, versions, data.cores)


def _named(name: str) -> str:
    """A name without the slashes of units and steps, which part the paths of figures."""
    return name.replace(" / ", " : ").replace("/", " per ")


def _whole(bench: Mapping[str, Any]) -> Row:
    runs = bench["runs"]
    return {
        "wanted": bench["wanted_runs"],
        "done": sum(run["verdict"] is not None for run in runs),
        "not_taken": sum(run["status"] == NOT_TAKEN for run in runs),
        "wrong": sum(bool(run["wrong_verdict"]) for run in runs),
        "numerical": sum(run["numerical"] is not None for run in runs),
        "cases": len({run["case"] for run in runs}),
    }


def _point(point: Mapping[str, Any], fronts: Mapping[str, Sequence[str]]) -> Row:
    beaten_by_none = [measure for measure, names in fronts.items() if point["name"] in names]
    return {
        "system": point["system"],
        "step": step_text(point["factor"]),
        "runs": point["runs"],
        "done": point["done"],
        "known": point["known"],
        "wrong": point["wrong_verdicts"],
        "numerical": point["numerical"],
        **{key: point["errors"].get(measure) for measure, key in ERRORS.items()},
        "energy_percent": point["energy_gain_percent"],
        "pace": point["wall_s_per_simulated_s"],
        "times_exact": point["pace_in_times_of_exact"],
        "wall_s": point["wall_time_s"],
        "simulated_s": point["simulated_time_s"],
        "steps": point["steps"],
        "solves": point["solves"],
        "memory_mib": point["peak_memory_bytes"] / MEBIBYTE,
        **_updates(point),
        "front": ", ".join(beaten_by_none),
    }


def _updates(told: Mapping[str, Any]) -> Row:
    """What one update of the extension took [ms]."""
    taken = {f"update_{which}_ms": told[f"update_{which}_s"] for which in ("median", "worst")}
    return {key: None if seconds is None else 1000.0 * seconds for key, seconds in taken.items()}


def by_system(points: Sequence[Mapping[str, Any]]) -> Rows:
    """Each system at its own step, called by its name alone."""
    own = [point for point in points if point["factor"] in OWN_STEP]
    return {
        point["system"]: {
            "known": point["known"],
            "wrong": point["wrong_verdicts"],
            "times_exact": point["pace_in_times_of_exact"],
        }
        for point in own
    }


def _pace(run: Mapping[str, Any]) -> float | None:
    """Seconds a second that was simulated; None where an assessor judged a single moment."""
    simulated = float(run["simulated_time_s"])
    return float(run["wall_time_s"]) / simulated if simulated else None


def _run(run: Mapping[str, Any], exact: float | None, bench: Mapping[str, Any]) -> Row:
    done, answer = run["verdict"] is not None, bench["answers"].get(run["case"])
    pace = _pace(run) if done else None
    return {
        "case": run["case"],
        "system": run["system"],
        "known": "" if answer is None else f"{'stands' if answer['stands'] else 'falls'}, {answer['source']}",
        "verdict": run["verdict"] or run["status"],
        "wrong": run["wrong_verdict"],
        "falls_at": (run["observations"] or {}).get("collapse level"),
        "levels": run["error_levels"],
        "creep_mm": run["creep_mm"],
        "length_mm": run["error_mm"],
        "angle_deg": run["error_deg"],
        "time_s": run["error_s"],
        "wall_s": run["wall_time_s"] if done else None,
        "steps": run["steps"] if done else None,
        "solves": run["solves"] if done else None,
        "memory_mib": run["peak_memory_bytes"] / MEBIBYTE if done else None,
        **_updates(run),
        "times_exact": pace / exact if pace and exact else None,
    }


def assessors(cases: Rows) -> Rows:
    """How many times as long as `exact` the assessors take, where both are right: apart by what comes of it."""
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
    """The long table, case by case, as Markdown."""
    rows = data.tables["runs"]
    for case in dict.fromkeys(str(row["case"]) for row in rows.values()):
        own = {name: row for name, row in rows.items() if row["case"] == case}
        known = next(iter(own.values()))["known"]
        yield f"\n### {case}{f': {known}' if known else ''}\n\n"
        yield table_text(RUN_TABLE, lambda _, own=own: Data(CASES, COMMAND, {"runs": own}))  # type: ignore[misc]


if __name__ == "__main__":
    main()
