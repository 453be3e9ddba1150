"""Tables of README and docs by name: the values and their formats."""

from collections.abc import Mapping

from benchmarks.figures.columns import Column, Table
from benchmarks.figures.moving_tables import MOVING_TABLES
from benchmarks.figures.statics_tables import STATICS_TABLES

_COMPARED = ("StackDSL", "pytest", "Playwright", "Vitest", "insta", "Hurl", "Tavern", "nuclei")
_POINT_COLUMNS = (
    Column("system", "`{system}`"),
    Column("step", "{step}"),
    Column("wrong verdicts", "{wrong} of {known}"),
    Column("numerical collapses", "{numerical}"),
    Column("levels", "{levels:g}"),
    Column("creep, mm", "{creep_mm:sig3}"),
    Column("length error, mm", "{length_mm:sig2}"),
    Column("time error, s", "{time_s:sig3}"),
    Column("energy error, %", "{energy_percent:sig2}"),
    Column("cost as a multiple of `exact`", "{times_exact:sig3}"),
    Column("update of the extension, median and worst, ms", "{update_median_ms:sig2}, {update_worst_ms:sig2}"),
    Column("best in", "{front}"),
)

TABLES: Mapping[str, Table] = {
    **MOVING_TABLES,
    **STATICS_TABLES,
    "human-error": Table(
        "human-error",
        "scenes",
        (
            Column("scene", "{scene}"),
            Column("standard deviations of errors", "{hands}"),
            Column("outcome without errors", "{without}"),
            Column("same outcome with errors", "{same_percent:.1f} %"),
            Column("claim", "{claim}"),
            Column("claim holds in", "{percent:.1f} % ({least_percent:.1f} .. {most_percent:.1f})"),
            Column("falls at levels", "{fell_at}"),
            Column("not proven", "{not_proven}"),
            Column("ms per sample", "{cpu_ms_a_sample:sig2}"),
        ),
    ),
    "human-error-apart": Table(
        "human-error",
        "apart",
        (
            Column("scene", "{scene}"),
            Column("standard deviations of errors", "{hands}"),
            Column("samples", "{samples}"),
            Column("placed planks", "{asked:,}"),
            Column("same outcome", "{alike}"),
            Column("contradicted", "{contradicted}"),
            Column("undecided", "{not_said}"),
            Column("difference of places, nm", "{off_nm:sig2}"),
        ),
    ),
    "card-houses-apart": Table(
        "card-houses-apart",
        "hands",
        (
            Column("standard deviations of errors", "{hands}"),
            Column("samples", "{samples}"),
            Column("stand", "{stand}"),
            Column("same outcome", "{alike}"),
            Column("contradicted", "{contradicted}"),
            Column("undecided", "{not_said}"),
        ),
    ),
    "fragility": Table(
        "fragility",
        "curves",
        (
            Column("curve", "{row}"),
            Column("samples", "{samples:,}"),
            Column("closed-form median", "{true_median:sig3} {unit}"),
            Column("error of the lognormal median", "{off_percent:+.2f} %"),
            Column("error of the interpolated median", "{half_off_percent:+.2f} %"),
            Column("points with the true share in their interval", "{points_that_hold_the_truth} of {points}"),
            Column("test of the lognormal fit", "{p}"),
            Column("ms per verdict", "{cpu_ms_a_verdict:sig2}"),
        ),
    ),
    "sampled-engines": Table(
        "samples",
        "engines",
        (
            Column("system", "`{row}`"),
            Column("samples", "{samples}"),
            Column("wrong verdicts", "{wrong}"),
            Column("wrong verdict or other level", "{other_level}"),
            Column("ms per sample", "{cpu_ms_a_sample:sig2}"),
        ),
    ),
    "four-stack": Table(
        "four-stack",
        "systems",
        (
            Column("system", "`{row}`"),
            Column("verdict", "{verdict}"),
            Column("error (largest drift)", "{drift}"),
            Column("engine steps", "{steps:,}"),
            Column("speed as a multiple of `tuned`", "{times_faster:sig2}"),
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
            Column("least friction of the card house", "{card_house_friction:.3f}"),
        ),
    ),
    "readings-piers": Table(
        "readings-counted",
        "piers",
        (
            Column("reading, on three to five piers", "{row}"),
            Column("stacks", "{stacks:,}"),
            Column("stable", "{stand}"),
            Column("stable, called unstable", "{stand_and_denied}"),
            Column("unstable, called stable", "{fall_and_held}"),
        ),
    ),
    "readings-hits": Table(
        "readings-counted",
        "hits",
        (
            Column("reading (woken planks, whole levels)", "{row}"),
            *(Column(f"level 3, {speed} m/s", f"{{level_3_{speed}}}") for speed in (1, 2, 4, 8)),
            *(Column(f"top, {speed} m/s", f"{{top_{speed}}}") for speed in (1, 2, 4)),
        ),
    ),
    "scale-paper": Table(
        "scale",
        "paper",
        (
            Column("samples", "{row}"),
            Column("computation, h", "{judging_h:sig2}"),
            Column("scheduler, h", "{scheduler_h:sig2}"),
            Column("writer, h", "{writer_h:sig2}"),
            Column("total, h", "{whole_h:sig2}"),
            Column("bottleneck", "{slowest}"),
            Column("busy cores", "{cores_that_are_kept_busy:,}"),
            Column("samples per piece", "{samples_a_piece:,}"),
        ),
    ),
    "scale-intervals": Table(
        "scale",
        "intervals",
        (
            Column("samples", "{row}"),
            Column("interval width at one look, %", "{percent_once:sig2}"),
            Column("looks during a check", "{looks}"),
            Column("interval width at all looks, %", "{percent_at_all_looks:sig2}"),
        ),
    ),
    "live": Table(
        "live",
        "scenes",
        (
            Column("scene", "{row}"),
            Column("median, ms", "{median_ms:sig2}"),
            Column("worst of five, ms", "{worst_ms:sig2}"),
            Column("processor time without the browser, ms", "{processor_ms:sig2}"),
        ),
    ),
    "recording": Table(
        "recording",
        "runs",
        (
            Column("run", "{row}"),
            Column("bricks", "{bricks}"),
            Column("additional processor time", "{overhead_percent:+.1f} %"),
            Column("stored poses", "{keys:,}"),
        ),
    ),
    "replay": Table(
        "replay",
        "scenes",
        (
            Column("scene", "{row}"),
            Column("page, MB", "{page_mb:sig2}"),
            Column("first frame, s", "{first_frame_s:sig2}"),
            Column("frames per second", "{frames_per_second:sig2}"),
            Column("processor time on two cores, ms per frame", "{processor_ms:sig2}"),
        ),
    ),
    "modified": Table(
        "modified",
        "scenes",
        (
            Column("", "{row}"),
            Column("four-stack, 30 levels", "{four_stack}"),
            Column("drift before the fall", "{four_stack_drift_mm:.1f} mm"),
            Column("slant tower", "{slant_tower}"),
            Column("card house of 3, 2, 1 Vs", "{card_house}"),
        ),
    ),
    "bench-systems": Table(
        "speed-against-error",
        "systems",
        (
            Column("system, at its own time step", "`{row}`"),
            Column("wrong verdicts", "{wrong} of {known}"),
            Column("cost as a multiple of `exact`", "{times_exact:sig2}"),
        ),
    ),
    "points": Table("speed-against-error", "points", _POINT_COLUMNS),
    **{
        name: Table(
            "collapse",
            name,
            (
                Column("", "{row}"),
                Column("time to 15 deg, ms", "{slow_ms:.1f}"),
                Column("time to landing, ms", "{lands_ms:.1f}"),
                Column("reach, mm", "{reach_mm:.1f}"),
                Column("direction error, deg", "{direction_deg:.2f}"),
                Column("proportion error, %", "{proportions_percent:.2f}"),
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
}
