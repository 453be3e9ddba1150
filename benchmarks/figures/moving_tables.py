"""Tables of moving structures, by name: hits, falls, slips and heaps, next to references."""

from collections.abc import Mapping
from itertools import product

from benchmarks.figures.columns import Column, Table

_MISSING = ("1", "3", "10", "50")  # [%] less than the required friction
_SLIPS = (
    *(f"{kind}, exact, step x 1" for kind in ("ladder", "V", "slope")),
    *(f"{kind}, tuned, step x {part}" for kind, part in product(("ladder", "V"), ("1", "0.5", "0.25"))),
    "slope, tuned, step x 1",
)
_HITS = tuple(f"level {level}, {speed} m per s" for level, speed in product((3, 13), (1, 2, 4)))
_PILES = (("pyramid of cans", "cans"), ("logs between blocks", "logs"), ("log in a wedge", "wedge"))
_MOVERS = ("pybullet", "unrepaired", "bare", "cone", "mujoco", "rigid")

MOVING_TABLES: Mapping[str, Table] = {
    "rigid-engine": Table(
        "rigid-engine",
        "known",
        (
            Column("quantity", "{case}"),
            Column("closed form or reference", "{reference:sig3}"),
            Column("`rigid`", "{engine:sig3}"),
            Column("error", "{error_percent:+.2f} %"),
        ),
    ),
    "rigid-engine-cost": Table(
        "rigid-engine",
        "costs",
        (
            Column("scene, every brick awake", "{scene}"),
            Column("`rigid`, ms of processor for 1 ms", "{engine_ms:sig2}"),
            Column("PyBullet without corrections, ms", "{pybullet_ms:sig2}"),
            Column("ratio", "{ratio:sig2}"),
        ),
    ),
    "round-bodies": Table(
        "round-bodies",
        "engines",
        (
            Column("engine of", "{system}"),
            *(Column(f"way of a {body}", f"{{{body}_percent:+.2f}} %") for body in ("ball", "log", "pipe")),
            Column("a can tips early by up to", "{early_deg:.2f} deg"),
            Column("friction angle of a can", "{slide_percent:+.1f} %"),
            *(Column(f"{pile}, mm", f"{{{key}_mm:.2f}}") for pile, key in _PILES),
        ),
    ),
    "movers": Table(
        "movers",
        "movers",
        (
            Column("what moves the bricks", "{mover}"),
            Column("errors over 3 %", "{over_3_percent} of {judged}"),
            Column("median error", "{median_percent:sig2} %"),
            Column("scenes that gain over 0.1 % of energy, largest gain", "{gained}, {gain_percent:.2f} %"),
            Column("processor time of a step, ms", "{step_ms:sig2}"),
            Column("as a multiple of a bare step", "{times_bare:sig2}"),
            Column("steps of the engine, s", "{engine_s:sig2}"),
            Column("whole runs, s", "{s:sig2}"),
            Column("lines of code", "{lines:,}"),
        ),
    ),
    "movers-kinds": Table(
        "movers",
        "kinds",
        (
            Column("largest error, processor time", "{row} ({scenes})"),
            *(Column(f"`{name}`", f"{{{name}_worst}}, {{{name}_s:sig2}} s") for name in _MOVERS),
        ),
    ),
    "movers-scenes": Table(
        "movers",
        "scenes",
        (
            Column("scene", "{row}"),
            Column("reference", "{source}"),
            Column("value", "{reference:sig3}"),
            Column("`rigid`, `mujoco` at small steps", "{fine_rigid:sig3}, {fine_mujoco:sig3}"),
            *(Column(f"`{name}`", f"{{{name}_error}}, {{{name}_s:sig2}} s") for name in _MOVERS),
        ),
    ),
    "movers-hits": Table(
        "movers",
        "scenes",
        (
            Column("shift of the hit plank, m", "{row}"),
            Column("impact law", "{reference:sig3}"),
            *(Column(f"`{name}` at small steps", f"{{fine_{name}:sig3}}") for name in ("rigid", "mujoco")),
            *(Column(f"`{name}`", f"{{{name}_value:sig3}}") for name in ("pybullet", "rigid", "mujoco")),
        ),
        (
            *(f"hits onto long sides: level {hit} m/s" for hit in ("3, 1", "3, 2", "3, 4", "13, 1", "13, 2.5")),
            "hits onto ends: level, 4 m/s",
            *(f"broadside and turned hits: {hit} m/s" for hit in ("90 deg, 1", "90 deg, 3", "60 deg, 2", "45 deg, 1")),
        ),
    ),
    "wall-hits": Table(
        "wall-hits",
        "runs",
        (
            Column("wall and hit", "{row}"),
            Column("`exact`, mm", "{hit_mm:sig3}"),
            Column("closed form, mm", "{truth_mm:sig3}"),
            Column("error", "{error_percent:+.1f} %"),
            Column("bricks woken one by one", "{one_by_one}"),
            Column("time, s", "{wall_s:sig2}"),
            Column("speed as a multiple of SAPIEN with all bricks awake", "{times_faster:sig2}"),
        ),
    ),
    "energy": Table(
        "energy",
        "heaps",
        (
            Column("random heaps", "{row}"),
            Column("heaps", "{heaps}"),
            Column("heaps with a gain over 0.1 %", "{gained}"),
            Column("largest gain", "{worst_percent:.2f} %"),
            Column("heaps with wrong edge normals", "{with_wrong_normals}"),
        ),
    ),
    "dropped": Table(
        "dropped",
        "heaps",
        (
            Column("released planks", "{row}"),
            Column("processor time, s", "{seconds:sig3}"),
            Column("steps", "{steps}"),
            Column("energy gained", "{gain_percent:.2f} %"),
        ),
    ),
    "costs": Table(
        "costs",
        "scenes",
        (
            Column("scene", "{row}"),
            Column("`exact`, s", "{exact}"),
            Column("`exact` before it had its own engine, s", "{before}"),
            Column("ratio", "{times}"),
            Column("`tuned`, s", "{tuned}"),
            Column("MuJoCo, s", "{mujoco}"),
            Column("SAPIEN, s", "{sapien}"),
        ),
    ),
    "published-falls": Table(
        "published-falls",
        "runs",
        (
            Column("", "{row}"),
            Column("slant tower: level of fall", "{slant_level}"),
            Column("slant tower: sideways motion, mm", "{slant_sideways_mm:.1f}"),
            Column("leaning structure: level of fall", "{leaning_level}"),
            Column("leaning structure: sideways motion, mm", "{leaning_sideways_mm:.1f}"),
        ),
    ),
    "sway": Table(
        "sway",
        "systems",
        (
            Column("system", "{row}"),
            *(Column(f"sway at {n} levels, mm", f"{{levels_{n}_mm:.4f}}") for n in (2, 4, 6)),
            Column("frequency at 6 levels, Hz", "{frequency_hz:.1f}"),
            Column("largest penetration, mm", "{depth_mm:.4f}"),
        ),
    ),
    "slips": Table(
        "slips",
        "errors",
        (
            Column("", "{row}"),
            *(Column(f"{missing} % missing", f"{{missing_{missing}_percent:+.2f}} %") for missing in _MISSING),
            Column("median", "{median_percent:.2f} %"),
            Column("stuck runs", "{stuck} of {cases}"),
            Column("cost of a run at 1/7680 s as a multiple", "{times_dearer:sig2}"),
        ),
        _SLIPS,
    ),
    "falls-in-parts": Table(
        "falls-in-parts",
        "falls",
        (
            Column("", "{row}"),
            Column("time to 5 deg, ms", "{due_ms:.1f}"),
            Column("delay", "{late_percent:+.2f} %"),
            Column("direction error, deg", "{direction_deg:.2f}"),
            Column("proportion error, %", "{proportions_percent:.2f}"),
        ),
    ),
    "leaning-slips": Table(
        "leaning-slips",
        "exact",
        (
            Column("", "{row}"),
            Column("cases", "{cases}"),
            Column("measured times", "{times}"),
            Column("without a reference value", "{without_truth}"),
            Column("median", "{median_percent:sig2} %"),
            Column("worst", "{worst_percent:sig2} %"),
            Column("errors over 3 %", "{over_3_percent}"),
            Column("difference between two steps of the reference", "{reference_apart_percent:sig2} %"),
            Column("reference also moves with 1 % more friction", "{moves_with_more}"),
        ),
    ),
    "hits": Table(
        "hits",
        "runs",
        (
            Column("level", "{level}"),
            Column("speed, m/s", "{speed:g}"),
            Column("`exact`, mm", "{exact_mm:sig3}"),
            Column("all awake, 1/1920 s, mm", "{coarse_mm:sig3}"),
            Column("all awake, 1/3840 s, mm", "{fine_mm:sig3}"),
            Column("error of `exact`", "{error_percent:+.1f} %"),
            Column("planks moved by 5 mm (`exact`, 1/3840 s)", "{exact_notable}, {fine_notable}"),
            Column("cost of both as a multiple of `exact`", "{coarse_times_dearer:sig2}, {fine_times_dearer:sig2}"),
        ),
        _HITS,
    ),
    "end-hits": Table(
        "end-hits",
        "hits",
        (
            Column("aim, and speed", "{row}"),
            Column("speed, m/s", "{speed:sig2}"),
            Column("offset sideways, mm", "{aside_mm:+.1f}"),
            Column("offset upwards, mm", "{above_mm:+.1f}"),
            Column("turn, deg", "{askew_deg:+.1f}"),
            Column("reference, mm", "{reference_mm:sig3}"),
            Column("reference at twice the step, mm", "{coarse_mm:sig3}"),
            Column("SAPIEN, mm", "{sapien_mm:sig3}"),
            Column("`exact`, mm", "{exact_mm:sig3}"),
            Column("error of `exact`", "{error_percent:+.1f} %"),
            Column("sensitive", "{sensitive}"),
        ),
    ),
    "invariance": Table(
        "invariance",
        "exact",
        (
            Column("scene", "{row}"),
            *(
                Column(changed, f"{{{changed}_pushed_percent:.2f}} %")
                for changed in ("turn", "mirror", "place", "names", "order", "apart", "size")
            ),
        ),
    ),
    "random-hits": Table(
        "random-hits",
        "all",
        (
            Column("hits", "{hits}"),
            Column("both references agree", "{converge}"),
            Column("`exact` within 3 % of these", "{within}"),
            Column("largest error", "{worst_percent:.0f} %"),
            Column("equal number of fallen bricks", "{same_fallen}"),
        ),
    ),
}
