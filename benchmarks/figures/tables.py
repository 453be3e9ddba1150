"""The tables of README and docs by name: which values each shows, and how."""

from collections.abc import Mapping
from itertools import product

from benchmarks.figures.columns import Column, Table

_MISSING = ("1", "3", "10", "50")  # [%] of the friction that would hold
_SLIPS = (
    *(f"{kind}, exact, step x 1" for kind in ("ladder", "V", "slope")),
    *(f"{kind}, tuned, step x {part}" for kind, part in product(("ladder", "V"), ("1", "0.5", "0.25"))),
    "slope, tuned, step x 1",
)
_HITS = tuple(f"level {level}, {speed} m per s" for level, speed in product((3, 13), (1, 2, 4)))
_POINT_COLUMNS = (
    Column("system", "`{system}`"),
    Column("step", "{step}"),
    Column("wrong verdicts", "{wrong} of {known}"),
    Column("numerical collapses", "{numerical}"),
    Column("levels", "{levels:g}"),
    Column("creep mm", "{creep_mm:sig3}"),
    Column("lengths mm", "{length_mm:sig2}"),
    Column("times s", "{time_s:sig3}"),
    Column("energy %", "{energy_percent:sig2}"),
    Column("pace in times of `exact`", "{times_exact:sig3}"),
    Column("update of the extension, median and worst ms", "{update_median_ms:sig2}, {update_worst_ms:sig2}"),
    Column("nobody beats it in", "{front}"),
)

TABLES: Mapping[str, Table] = {
    "four-stack": Table(
        "four-stack",
        "systems",
        (
            Column("system", "`{row}`"),
            Column("verdict", "{verdict}"),
            Column("error: largest drift", "{drift}"),
            Column("engine steps", "{steps:,}"),
            Column("times faster than `tuned`, for a simulated second", "{times_faster:sig2}"),
        ),
    ),
    "statics": Table(
        "statics",
        "costs",
        (
            Column("question", "{row}"),
            Column("cost, ms", "{cost_ms:sig2}"),
            Column("error", "{error:sig1} {error_of}"),
        ),
    ),
    "compas": Table(
        "against-compas",
        "counts",
        (
            Column("blocks", "{row}"),
            *(
                Column(f"`{program}`, {told}", f"{{{program}_{key}:sig2}}")
                for program in ("rbe", "cra")
                for told, key in (
                    ("four-stack", "stack"),
                    ("wall", "wall"),
                    ("column at 0.95", "column_95"),
                    ("column at 1.05", "column_105"),
                )
            ),
        ),
        ("5", "10", "20", "50", "100"),
    ),
    "bench-systems": Table(
        "speed-against-error",
        "systems",
        (
            Column("system, at its own time step", "`{row}`"),
            Column("wrong verdicts", "{wrong} of {known}"),
            Column("time, in times of `exact`", "{times_exact:sig2}"),
        ),
    ),
    "points": Table("speed-against-error", "points", _POINT_COLUMNS),
    "slips": Table(
        "slips",
        "errors",
        (
            Column("", "{row}"),
            *(Column(f"{missing} % missing", f"{{missing_{missing}_percent:+.2f}} %") for missing in _MISSING),
            Column("median", "{median_percent:.2f} %"),
            Column("stuck", "{stuck} of {cases}"),
            Column("a run at 1/7680 s is so many times as dear", "{times_dearer:sig2}"),
        ),
        _SLIPS,
    ),
    **{
        name: Table(
            "collapse",
            name,
            (
                Column("", "{row}"),
                Column("15 deg after, ms", "{slow_ms:.1f}"),
                Column("lands after, ms", "{lands_ms:.1f}"),
                Column("reach, mm", "{reach_mm:.1f}"),
                Column("direction off by, deg", "{direction_deg:.2f}"),
                Column("proportions off by, %", "{proportions_percent:.2f}"),
                Column("energy gained, %", "{energy_percent:.2f}"),
            ),
        )
        for name in ("slant-tower", "slant-tower-flush")
    },
    "hits": Table(
        "hits",
        "runs",
        (
            Column("level", "{level}"),
            Column("speed, m/s", "{speed:g}"),
            Column("`exact`, mm", "{exact_mm:sig3}"),
            Column("all awake 1/1920 s, mm", "{coarse_mm:sig3}"),
            Column("all awake 1/3840 s, mm", "{fine_mm:sig3}"),
            Column("error of `exact`", "{error_percent:+.1f} %"),
            Column("planks moved by 5 mm", "{exact_notable}, {fine_notable}"),
            Column("times as dear as `exact`", "{coarse_times_dearer:sig2}, {fine_times_dearer:sig2}"),
        ),
        _HITS,
    ),
    "thesis-against-exact": Table(
        "thesis-against-exact",
        "piles",
        (
            Column("`thesis` says", "{row}"),
            Column("truly stable", "{stable}"),
            Column("truly unstable", "{unstable}"),
        ),
        ("stable", "unstable"),
    ),
}
