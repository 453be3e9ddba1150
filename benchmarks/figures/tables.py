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
_COMPARED = ("StackDSL", "pytest", "Playwright", "Vitest", "insta", "Hurl", "Tavern", "nuclei")
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
    "human-error": Table(
        "human-error",
        "scenes",
        (
            Column("scene", "{scene}"),
            Column("errors, standard deviations", "{hands}"),
            Column("without errors", "{without}"),
            Column("the same with them", "{same_percent:.1f} %"),
            Column("claim", "{claim}"),
            Column("holds in", "{percent:.1f} % ({least_percent:.1f} .. {most_percent:.1f})"),
            Column("falls at levels", "{fell_at}"),
            Column("not proven", "{not_proven}"),
            Column("ms a sample", "{cpu_ms_a_sample:sig2}"),
        ),
    ),
    "human-error-apart": Table(
        "human-error",
        "apart",
        (
            Column("scene", "{scene}"),
            Column("errors, standard deviations", "{hands}"),
            Column("samples", "{samples}"),
            Column("planks set down", "{asked:,}"),
            Column("same level, or both stand", "{alike}"),
            Column("contradicted", "{contradicted}"),
            Column("not said", "{not_said}"),
            Column("places differ by, nm", "{off_nm:sig2}"),
        ),
    ),
    "card-houses-apart": Table(
        "card-houses-apart",
        "hands",
        (
            Column("errors, standard deviations", "{hands}"),
            Column("samples", "{samples}"),
            Column("stand", "{stand}"),
            Column("same level, or both stand", "{alike}"),
            Column("contradicted", "{contradicted}"),
            Column("not said", "{not_said}"),
        ),
    ),
    "fragility": Table(
        "fragility",
        "curves",
        (
            Column("curve", "{row}"),
            Column("samples", "{samples:,}"),
            Column("half fall at, closed form", "{true_median:sig3} {unit}"),
            Column("lognormal median, off by", "{off_percent:+.2f} %"),
            Column("by the points alone, off by", "{half_off_percent:+.2f} %"),
            Column("points whose interval holds the truth", "{points_that_hold_the_truth} of {points}"),
            Column("points that the lognormal misses", "{points_that_the_curve_misses}"),
            Column("ms a verdict", "{cpu_ms_a_verdict:sig2}"),
        ),
    ),
    "sampled-engines": Table(
        "samples",
        "engines",
        (
            Column("system", "`{row}`"),
            Column("samples", "{samples}"),
            Column("wrong verdicts", "{wrong}"),
            Column("another level, or wrong", "{other_level}"),
            Column("ms a sample", "{cpu_ms_a_sample:sig2}"),
        ),
    ),
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
    "readings": Table(
        "readings",
        "scenes",
        (
            Column("", "{row}"),
            Column("four-stack, 30 levels", "{four_stack}"),
            Column("slant tower", "{slant}"),
            Column("leaning structure", "{leaning}"),
            Column("card house of 3, 2, 1 Vs, friction 0.5", "{card_house}"),
            Column("it stands from friction", "{card_house_friction:.3f}"),
        ),
    ),
    "scale-paper": Table(
        "scale",
        "paper",
        (
            Column("samples of", "{row}"),
            Column("judging, h", "{judging_h:sig2}"),
            Column("the scheduler, h", "{scheduler_h:sig2}"),
            Column("the writer, h", "{writer_h:sig2}"),
            Column("in all, h", "{whole_h:sig2}"),
            Column("what it waits for", "{slowest}"),
            Column("cores that are kept busy", "{cores_that_are_kept_busy:,}"),
            Column("samples of a piece", "{samples_a_piece:,}"),
        ),
    ),
    "scale-intervals": Table(
        "scale",
        "intervals",
        (
            Column("samples", "{row}"),
            Column("width at one look, %", "{percent_once:sig2}"),
            Column("looks of a check", "{looks}"),
            Column("width at each of these, %", "{percent_at_all_looks:sig2}"),
        ),
    ),
    "pallets": Table(
        "pallets",
        "settled",
        (
            Column("settled", "`{row}`"),
            Column("stable", "{stable}"),
            Column("of these guaranteed", "{guaranteed}"),
            Column("possible", "{possible}"),
            Column("unstable", "{unstable}"),
            Column("undecided", "{undecided}"),
            Column("all, s", "{seconds:sig2}"),
            Column("the slowest, s", "{worst_s:sig2}"),
            Column("one placement, 99 of 100, ms", "{placement_99_ms:sig2}"),
        ),
    ),
    "survived": Table(
        "survived",
        "loads",
        (
            Column("144 boxes", "{row}"),
            Column("contacts", "{contacts:,.0f}"),
            Column("groups that do not touch", "{groups}"),
            Column("directions solved", "{directions}"),
            Column("72 bearings, s of one core", "{seconds:sig2}"),
            Column("waited on two cores, s", "{waited_s:sig2}"),
            Column("unproven, %", "{unproven_percent:sig2}"),
            Column("survives, g", "{worst_g:.3f}"),
        ),
    ),
    "outcomes": Table(
        "outcomes",
        "groups",
        (
            Column("groups that stand by friction alone", "{row}"),
            Column("how many", "{groups}"),
            Column("can only rest", "{rests}"),
            Column("can let go as well", "{lets_go}"),
            Column("not decided", "{undecided}"),
            Column("contradicted by all modes in the plane", "{contradicted}"),
            Column("median, ms", "{median_ms:sig2}"),
            Column("the slowest, ms", "{worst_ms:sig2}"),
        ),
    ),
    "compas-samples": Table(
        "compas-samples",
        "samples",
        (
            Column("sample", "{row}"),
            Column("blocks", "{blocks}"),
            Column("interfaces", "{interfaces}"),
            Column("`exact`", "{exact}"),
            Column("ms", "{exact_ms:sig2}"),
            Column("`cra`", "{cra}"),
            Column("times as long", "{times_slower}"),
            Column("the file by `import`", "{own}"),
        ),
    ),
    "find": Table(
        "find",
        "scenes",
        (
            Column("scene", "{row}"),
            Column("asked", "{asked}"),
            Column("known from", "{closed_form}"),
            Column("truth", "{truth}"),
            Column("stands", "{stands}"),
            Column("falls", "{beyond}"),
            Column("error", "{error:sig2}"),
            Column("by", "{how}"),
            Column("verdicts", "{verdicts}"),
            Column("ms", "{ms:sig2}"),
        ),
    ),
    "slopes": Table(
        "slopes",
        "scenes",
        (
            Column("scene, margin", "{row}"),
            Column("numbers", "{numbers}"),
            Column("that matter", "{matter}"),
            Column("slopes from duals that differences confirm", "{agree}"),
            Column("that they contradict", "{contradicted}"),
            Column("kinks", "{kinks}"),
            Column("a slope from duals, ms", "{duals_ms:sig2}"),
            Column("a slope from differences, ms", "{differences_ms:sig2}"),
        ),
    ),
    "live": Table(
        "live",
        "scenes",
        (
            Column("scene", "{row}"),
            Column("median, ms", "{median_ms:sig2}"),
            Column("worst of five, ms", "{worst_ms:sig2}"),
            Column("of the processor, without the browser, ms", "{processor_ms:sig2}"),
        ),
    ),
    "recording": Table(
        "recording",
        "runs",
        (
            Column("run", "{row}"),
            Column("bricks", "{bricks}"),
            Column("time of the processor beside that of a run that is not recorded", "{overhead_percent:+.1f} %"),
            Column("poses kept", "{keys:,}"),
        ),
    ),
    "replay": Table(
        "replay",
        "scenes",
        (
            Column("scene", "{row}"),
            Column("page, MB", "{page_mb:sig2}"),
            Column("first frame, s", "{first_frame_s:sig2}"),
            Column("frames a second", "{frames_per_second:sig2}"),
            Column("of two processors, ms a frame", "{processor_ms:sig2}"),
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
    "modified": Table(
        "modified",
        "scenes",
        (
            Column("", "{row}"),
            Column("four-stack, 30 levels", "{four_stack}"),
            Column("largest drift before", "{four_stack_drift_mm:.1f} mm"),
            Column("slant tower", "{slant_tower}"),
            Column("card house of 3, 2, 1 Vs", "{card_house}"),
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
    "compared": Table(
        "compared",
        "tools",
        (
            Column("", "{row}"),
            Column("version", "{version}"),
            Column("seen in a run", "{run}"),
            Column("from its documentation", "{documented}"),
            Column("not tried", "{not_tried}"),
        ),
        _COMPARED,
    ),
    **{
        f"compared-{group}": Table(
            "compared", group, (Column("", "{row}"), *(Column(tool, f"{{{tool}}}") for tool in _COMPARED))
        )
        for group in ("choosing", "iterating", "writing", "snapshots", "reports", "mistakes", "trust", "project")
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
    "pulls": Table(
        "mending",
        "pulls",
        (
            Column("tower", "{row}"),
            Column("single pulls: stand, fall", "{stand}, {fall}"),
            Column("wrong", "{wrong} of {pulls}"),
            Column("a pull, ms", "{pull_ms:sig2}"),
            Column("longest order", "{longest}, at most {at_most}"),
            Column("falls soonest with", "{soonest}"),
            Column("both orders, s", "{orders_s:sig2}"),
        ),
    ),
    "mending": Table(
        "mending",
        "piles",
        (
            Column("random piles", "{row}"),
            Column("mended", "{mended} of {piles}"),
            Column("verified", "{verified}"),
            Column("by one shift", "{one_shift}"),
            Column("several shifts", "{several_shifts}"),
            Column("a counterweight", "{counterweight}"),
            Column("friction", "{friction}"),
            Column("props alone", "{props}"),
            Column("s, median and worst", "{median_s:sig2}, {worst_s:sig2}"),
        ),
    ),
    "remedies": Table(
        "mending",
        "remedies",
        (
            Column("told", "{row}"),
            Column("times", "{told}"),
            Column("for all of the pile", "{of_all}"),
            Column("stand", "{stand}"),
            Column("fall", "{fall}"),
            Column("not said", "{not_said}"),
            Column("fall with less", "{fall_with_less}"),
        ),
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
