"""Tables of proofs by statics, by name: loads, samples, limits, remedies and their cost."""

from collections.abc import Mapping

from benchmarks.figures.columns import Column, Table

STATICS_TABLES: Mapping[str, Table] = {
    "pallets": Table(
        "pallets",
        "settled",
        (
            Column("settled", "`{row}`"),
            Column("stable", "{stable}"),
            Column("guaranteed", "{guaranteed}"),
            Column("possible", "{possible}"),
            Column("unstable", "{unstable}"),
            Column("undecided", "{undecided}"),
            Column("total, s", "{seconds:sig2}"),
            Column("slowest, s", "{worst_s:sig2}"),
            Column("99th percentile of a placement, ms", "{placement_99_ms:sig2}"),
        ),
    ),
    "survived": Table(
        "survived",
        "loads",
        (
            Column("144 boxes", "{row}"),
            Column("contacts", "{contacts:,.0f}"),
            Column("separate groups", "{groups}"),
            Column("solved directions", "{directions}"),
            Column("processor time for 72 bearings, s", "{seconds:sig2}"),
            Column("wall time on two cores, s", "{waited_s:sig2}"),
            Column("unproven remainder, %", "{unproven_percent:sig2}"),
            Column("survived acceleration, g", "{worst_g:.3f}"),
        ),
    ),
    "slow-studies": Table(
        "slow-studies",
        "studies",
        (
            Column("study", "{row}"),
            Column("bricks", "{bricks:,.0f}"),
            Column("processor time, s", "{seconds:sig2}"),
            Column("as a multiple of the peer", "{times_peer:sig2}"),
            Column("memory of the process, MB", "{peak_mb:.0f}"),
            Column("error, %", "{error_percent:sig2}"),
        ),
    ),
    "outcomes": Table(
        "outcomes",
        "groups",
        (
            Column("groups that stand by friction alone", "{row}"),
            Column("groups", "{groups}"),
            Column("only rest possible", "{rests}"),
            Column("motion also possible", "{lets_go}"),
            Column("undecided", "{undecided}"),
            Column("contradicted by plane modes", "{contradicted}"),
            Column("median, ms", "{median_ms:sig2}"),
            Column("slowest, ms", "{worst_ms:sig2}"),
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
            Column("motion without prestress", "{lets_go}"),
            Column("`cra`", "{cra}"),
            Column("time as a multiple of `exact`", "{times_slower}"),
            Column("result of `import`", "{own}"),
        ),
    ),
    "solids-in-engines": Table(
        "solids-in-engines",
        "systems",
        (
            Column("system", "`{row}`"),
            Column("assemblies", "{assemblies}"),
            Column("stable assemblies", "{stand}"),
            Column("stable, fall in the system", "{falls_though_stable}"),
            Column("unstable, stand in the system", "{stands_though_unstable}"),
            Column("ms per assembly", "{ms:sig2}"),
        ),
    ),
    "touching": Table(
        "touching",
        "verdicts",
        (
            Column("assemblies", "{assemblies}"),
            Column("stable", "{stable}"),
            Column("stable only with gaps as contacts", "{across_gaps}"),
            Column("unstable", "{unstable}"),
            Column("undecided", "{undecided}"),
            Column("wrong stable", "{stable_contradicted}"),
            Column("missing gap report", "{gap_not_told}"),
            Column("needless gap report", "{gap_told_for_nothing}"),
            Column("wrong unstable", "{unstable_contradicted}"),
        ),
    ),
    "find": Table(
        "find",
        "scenes",
        (
            Column("scene", "{row}"),
            Column("limit", "{asked}"),
            Column("source of the truth", "{closed_form}"),
            Column("true value", "{truth}"),
            Column("stands", "{stands}"),
            Column("falls", "{beyond}"),
            Column("error", "{error:sig2}"),
            Column("method", "{how}"),
            Column("verdicts", "{verdicts}"),
            Column("ms", "{ms:sig2}"),
        ),
    ),
    "slopes": Table(
        "slopes",
        "scenes",
        (
            Column("scene, margin", "{row}"),
            Column("inputs", "{numbers}"),
            Column("inputs with an effect", "{matter}"),
            Column("dual slopes confirmed by differences", "{agree}"),
            Column("dual slopes contradicted", "{contradicted}"),
            Column("kinks", "{kinks}"),
            Column("one slope from duals, ms", "{duals_ms:sig2}"),
            Column("one slope from differences, ms", "{differences_ms:sig2}"),
        ),
    ),
    "statics": Table(
        "statics",
        "costs",
        (
            Column("task", "{row}"),
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
    "joined": Table(
        "joined",
        "joined",
        (
            Column("joints", "{row}"),
            Column("assemblies", "{cases}"),
            Column("stable, unstable", "{stable}, {unstable}"),
            Column("undecided", "{undecided}"),
            Column("contradicted", "{contradicted}"),
            Column("between both programs", "{open}"),
            Column("load factors outside", "{factors_outside}"),
            Column("load factors unproven", "{factors_unproven}"),
            Column("median and worst time, ms", "{median_ms:sig2}, {worst_ms:sig2}"),
        ),
    ),
    "pulls": Table(
        "mending",
        "pulls",
        (
            Column("tower", "{row}"),
            Column("single pulls: stand, fall", "{stand}, {fall}"),
            Column("wrong", "{wrong} of {pulls}"),
            Column("ms per pull", "{pull_ms:sig2}"),
            Column("pulls in the longest order", "{longest}, at most {at_most}"),
            Column("pulls in the shortest order to a fall", "{soonest}"),
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
            Column("one shift", "{one_shift}"),
            Column("several shifts", "{several_shifts}"),
            Column("counterweight", "{counterweight}"),
            Column("friction", "{friction}"),
            Column("props only", "{props}"),
            Column("median and worst time, s", "{median_s:sig2}, {worst_s:sig2}"),
        ),
    ),
    "remedies": Table(
        "mending",
        "remedies",
        (
            Column("remedy", "{row}"),
            Column("suggestions", "{told}"),
            Column("for the whole pile", "{of_all}"),
            Column("stand", "{stand}"),
            Column("fall", "{fall}"),
            Column("undecided", "{not_said}"),
            Column("fall with a reduced remedy", "{fall_with_less}"),
        ),
    ),
    "thesis-against-exact": Table(
        "thesis-against-exact",
        "piles",
        (
            Column("verdict of `thesis`", "{row}"),
            Column("truly stable", "{stable}"),
            Column("truly unstable", "{unstable}"),
        ),
        ("stable", "unstable"),
    ),
}
