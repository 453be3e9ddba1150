"""The tables of what moves, by name: hits, falls, slips and heaps beside references."""

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

MOVING_TABLES: Mapping[str, Table] = {
    "wall-hits": Table(
        "wall-hits",
        "runs",
        (
            Column("wall and hit", "{row}"),
            Column("`exact`, mm", "{hit_mm:sig3}"),
            Column("closed form, mm", "{truth_mm:sig3}"),
            Column("error", "{error_percent:+.1f} %"),
            Column("one by one", "{one_by_one}"),
            Column("s", "{wall_s:sig2}"),
            Column("times faster than SAPIEN, all awake", "{times_faster:sig2}"),
        ),
    ),
    "energy": Table(
        "energy",
        "heaps",
        (
            Column("random heaps", "{row}"),
            Column("number", "{heaps}"),
            Column("gain over 1 %", "{gained}"),
            Column("worst gain", "{worst_percent:.2f} %"),
            Column("with wrong edge normals", "{with_wrong_normals}"),
        ),
    ),
    "dropped": Table(
        "dropped",
        "heaps",
        (
            Column("planks let go", "{row}"),
            Column("s of one core", "{seconds:sig3}"),
            Column("steps", "{steps}"),
            Column("energy gained", "{gain_percent:.2f} %"),
        ),
    ),
    "published-falls": Table(
        "published-falls",
        "runs",
        (
            Column("", "{row}"),
            Column("slant tower: falls at level", "{slant_level}"),
            Column("slant tower: sideways, mm", "{slant_sideways_mm:.1f}"),
            Column("leaning structure: falls at level", "{leaning_level}"),
            Column("leaning structure: sideways, mm", "{leaning_sideways_mm:.1f}"),
        ),
    ),
    "sway": Table(
        "sway",
        "systems",
        (
            Column("system", "{row}"),
            *(Column(f"sway at {n} levels, mm", f"{{levels_{n}_mm:.4f}}") for n in (2, 4, 6)),
            Column("how often a second, at 6", "{frequency_hz:.1f}"),
            Column("deepest, mm", "{depth_mm:.4f}"),
        ),
    ),
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
    "falls-in-parts": Table(
        "falls-in-parts",
        "falls",
        (
            Column("", "{row}"),
            Column("5 deg after, ms", "{due_ms:.1f}"),
            Column("late", "{late_percent:+.2f} %"),
            Column("direction off by, deg", "{direction_deg:.2f}"),
            Column("proportions off by, %", "{proportions_percent:.2f}"),
        ),
    ),
    "leaning-slips": Table(
        "leaning-slips",
        "exact",
        (
            Column("", "{row}"),
            Column("cases", "{cases}"),
            Column("times", "{times}"),
            Column("without a truth", "{without_truth}"),
            Column("median", "{median_percent:sig2} %"),
            Column("worst", "{worst_percent:sig2} %"),
            Column("over 3 %", "{over_3_percent}"),
            Column("to an engine before the last way", "{handed_over_early}"),
            Column("two steps of the reference apart", "{reference_apart_percent:sig2} %"),
            Column("reference moves with 1 % more friction", "{moves_with_more}"),
        ),
    ),
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
    "end-hits": Table(
        "end-hits",
        "hits",
        (
            Column("aim, and speed", "{row}"),
            Column("speed, m/s", "{speed:sig2}"),
            Column("aside, mm", "{aside_mm:+.1f}"),
            Column("above, mm", "{above_mm:+.1f}"),
            Column("askew, deg", "{askew_deg:+.1f}"),
            Column("reference, mm", "{reference_mm:sig3}"),
            Column("at twice the step, mm", "{coarse_mm:sig3}"),
            Column("SAPIEN, mm", "{sapien_mm:sig3}"),
            Column("`exact`, mm", "{exact_mm:sig3}"),
            Column("error of `exact`", "{error_percent:+.1f} %"),
            Column("sensitive", "{sensitive}"),
        ),
    ),
}
