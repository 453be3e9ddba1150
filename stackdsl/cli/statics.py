"""Commands that ask statics about one file: `survive`, `find`, `sensitivities`, `suggest`, `order`, `pull`."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import Any

import click

from stability.analysis.building_order import BuildingOrder, OrderSearch
from stability.analysis.removal_order import LongestSearch, Pull, carrying, single_pulls, soonest_fall
from stability.analysis.subset_search import Subsets, props_of
from stability.model import BodyId
from stability.problem import Stability
from stability.statics.assembly import Assembly
from stackdsl.asked_files import write_asked
from stackdsl.checking.cases import Case
from stackdsl.checking.selection import Selection
from stackdsl.cli.options import (
    ON_KEYWORD,
    ON_SYSTEMS,
    ONE_FILE,
    FilePath,
    Number,
    code_without_runs,
    selected_of,
    variants_of,
)
from stackdsl.cli.terminal import counted, tell, write, write_data
from stackdsl.exits import ExitCode
from stackdsl.judging.proofs import Proofs, Survival, finished_structure_of, piling_of, proofs_of, survival_of
from stackdsl.judging.remedies import FallingBuild, Suggestion, suggestions
from stackdsl.language.quantities import ANGLE, MistakeError, parse_quantity
from stackdsl.report.plots import HINT, drawn_survival
from stackdsl.report.studies import (
    FORMAT,
    limit_csv,
    limit_json,
    limit_lines,
    longest_lines,
    order_lines,
    order_rows,
    pull_lines,
    pull_row,
    sensitivity_csv,
    sensitivity_json,
    sensitivity_lines,
    soonest_line,
    suggestion_row,
    survival_csv,
    survival_json,
    survival_lines,
    table_csv,
)
from stackdsl.studies.find_limit import ACCURACY, FINEST, FoundLimit, SearchError, Want, Wish, find_in
from stackdsl.studies.sensitivities import CHECKED, MarginKind, Sensitivities, sensitivities_of
from stackdsl.wording import how_many

# `stackdsl survive`: what a structure survives when it is shaken or tilted, by bearing, and what gives way first.


PLOTS = (".svg", ".png")
FEWEST_BEARINGS, MOST_BEARINGS = 4, 3600


@click.command("survive")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@click.option(
    "--bearings",
    type=click.IntRange(FEWEST_BEARINGS, MOST_BEARINGS),
    default=72,
    show_default=True,
    help="Directions, evenly around.",
)
@click.option("--accuracy", type=Number(1e-6, 0.5), default=0.01, show_default=True, help="Share that may be unproven.")
@click.option("--format", "form", type=click.Choice(["text", "csv", "json"]), default="text", help="How it is written.")
@click.option("--plot", type=FilePath, help="Draw it to this .svg or .png; of one case.")
@click.pass_context
def survive_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    systems: tuple[str, ...],
    keyword: str,
    bearings: int,
    accuracy: float,
    form: str,
    plot: Path | None,
) -> None:
    """Tell what the finished structure of FILE survives when it is shaken or tilted, and what gives way first."""
    if plot is not None and plot.suffix.lower() not in PLOTS:
        raise click.UsageError(f"{plot}: write to a file that ends in {' or '.join(PLOTS)}")
    gathered, selected = selected_of(file, Selection(systems, keyword))
    cases = list(variants_of(selected).items())
    if plot is not None and len(cases) > 1:
        raise click.UsageError(f"--plot draws one case, and there are {len(cases)}: choose one with -k")
    found: list[tuple[str, Survival]] = []
    for name, case in cases:
        survival = _survival(name, case, bearings, accuracy)
        if survival is not None:
            found.append((name, survival))
            if form == "text":
                write("\n".join(survival_lines(name, survival)) + "\n")
    if form == "csv":
        write_data(survival_csv(found), "csv")
    elif form == "json":
        write_data(json.dumps(survival_json(found), indent=2) + "\n", "json")
    if plot is not None and found:
        _draw(*found[0], plot)
    context.exit(code_without_runs(gathered, selected))


def _survival(name: str, case: Case, bearings: int, accuracy: float) -> Survival | None:
    """What a case survives; why it is not known is told."""
    proofs = proofs_of(case.timeline)
    verdict, standing = proofs.verdict, len(proofs.assembly.bricks)
    count = sum(not placement.hits for placement in case.timeline.placements)
    if standing == 0:
        tell(f"{name}: nothing is set down at rest, so there is nothing that statics could judge")
        return None
    if verdict.reason:
        tell(f"{name}: {verdict.stability.upper()}: {verdict.reason}; what does not stand survives nothing")
        return None
    if standing < count:
        tell(
            f"{name}: this is what {standing} of {count} bricks survive; the engine has a word in all that comes after"
        )
    with counted(bearings, f"{name}: bearings") as known:
        survival = survival_of(proofs.assembly, bearings, accuracy, known)
    if survival is None:
        tell(f"{name}: no forces were found deep enough within friction to say what it survives")
    return survival


def _draw(name: str, survival: Survival, path: Path) -> None:
    try:
        write_asked(path, drawn_survival(name, survival, path.suffix))
    except ModuleNotFoundError as error:
        raise click.ClickException(f"--plot needs {error.name}, which is not installed; try: {HINT}") from error
    except OSError as error:
        raise click.ClickException(f"{path} cannot be written: {error.strerror}") from error


# `stackdsl find`: the largest or the least number with which a scenario stands, proven from both sides.


USUALLY = 60  # numbers that are tried; a bar has to end somewhere


def _bearing(context: click.Context, parameter: click.Parameter, value: str | None) -> float | None:
    try:
        return None if value is None else parse_quantity(value, ANGLE)
    except MistakeError as mistake:
        raise click.BadParameter(f"{mistake.message}; {mistake.hint}", context, parameter) from mistake


@click.command("find")
@ONE_FILE
@click.option("--largest", metavar="NAME", multiple=True, help="The largest number with which it stands.")
@click.option("--least", metavar="NAME", multiple=True, help="The least number with which it stands.")
@click.option("--most", metavar="NAME", multiple=True, help="The largest whole number with which it stands.")
@click.option("--from", "low", metavar="VALUE", default="", help="Search from here.")
@click.option("--to", "high", metavar="VALUE", default="", help="Search up to here.")
@click.option(
    "--within",
    "accuracy",
    type=Number(FINEST, 0.5),
    default=ACCURACY,
    show_default=True,
    help="Share by which both sides of a limit may be apart.",
)
@click.option("--bearing", callback=_bearing, metavar="ANGLE", help="Of a tilt or an acceleration; default: the worst.")
@ON_SYSTEMS
@ON_KEYWORD
@click.option("--format", "form", type=click.Choice(["text", "csv", "json"]), default="text", help="How it is written.")
@click.pass_context
def find_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    largest: tuple[str, ...],
    least: tuple[str, ...],
    most: tuple[str, ...],
    low: str,
    high: str,
    accuracy: float,
    bearing: float | None,
    systems: tuple[str, ...],
    keyword: str,
    form: str,
) -> None:
    """Find the largest or the least number with which FILE stands, proven from both sides; nothing is played."""
    wanted = [*((Want.LARGEST, name) for name in largest), *((Want.LEAST, name) for name in least)]
    wanted += [(Want.MOST, name) for name in most]
    if not wanted:
        raise click.UsageError("say what to find, such as --largest step, --least friction or --most levels")
    wishes = [Wish(want, name.strip(), low, high, accuracy, bearing) for want, name in wanted]
    gathered, selected = selected_of(file, Selection(systems, keyword))
    found: list[FoundLimit] = []
    try:
        for finding in _found_limits(selected, wishes):
            found.append(finding)
            if form == "text":
                write("\n".join(limit_lines(finding)) + "\n")
    finally:  # also of what is interrupted
        if form == "csv":
            write_data(limit_csv(found), "csv")
        elif form == "json":
            write_data(json.dumps(limit_json(found), indent=2) + "\n", "json")
    context.exit(code_without_runs(gathered, selected) if found or not selected else ExitCode.USAGE)


def _found_limits(selected: Sequence[Case], wishes: Sequence[Wish]) -> Iterator[FoundLimit]:
    """What is found of each case that can be asked; why others cannot is told."""
    for wish in wishes:
        for name, case in variants_of(selected, wish.name).items():
            try:
                with counted(USUALLY, f"{name}: {wish.want} {wish.name}") as tried:
                    finding = find_in(case, name, wish, tried)
            except SearchError as error:
                tell(f"{name}: {error}")
                continue
            yield finding


# `stackdsl sensitivities`: on which bricks, joints and numbers the margin of a structure depends most.


SHOWN = 15


@click.command("sensitivities")
@ONE_FILE
@click.option(
    "--of",
    type=click.Choice([each.value for each in MarginKind]),
    default=MarginKind.ACCELERATION.value,
    help="The margin.",
)
@click.option(
    "--check", "checked", type=click.IntRange(0), default=CHECKED, show_default=True, help="So many by differences."
)
@click.option("--top", type=click.IntRange(1), default=SHOWN, show_default=True, help="So many lines of text.")
@ON_SYSTEMS
@ON_KEYWORD
@click.option("--format", "form", type=click.Choice(["text", "csv", "json"]), default="text", help="How it is written.")
@click.pass_context
def sensitivities_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    of: str,
    checked: int,
    top: int,
    systems: tuple[str, ...],
    keyword: str,
    form: str,
) -> None:
    """Tell on which bricks, joints and numbers of FILE its margin depends most; nothing is played."""
    gathered, selected = selected_of(file, Selection(systems, keyword))
    found: list[Sensitivities] = []
    try:
        for each in _found_sensitivities(selected, MarginKind(of), checked):
            found.append(each)
            if form == "text":
                write("\n".join(sensitivity_lines(each, top)) + "\n")
    finally:  # also of what is interrupted
        if form == "csv":
            write_data(sensitivity_csv(found), "csv")
        elif form == "json":
            write_data(json.dumps(sensitivity_json(found), indent=2) + "\n", "json")
    context.exit(code_without_runs(gathered, selected))


def _found_sensitivities(selected: Sequence[Case], of: MarginKind, checked: int) -> Iterator[Sensitivities]:
    """What is found of each case; why of some nothing is, is told."""
    for name, case in variants_of(selected).items():
        try:
            with counted(100, f"{name}: percent") as known:
                each = sensitivities_of(case, name, of, checked, lambda done, total: known(round(100 * done / total)))
        except SearchError as error:
            tell(f"{name}: {error}")
            continue
        yield each


# What commands have in common that ask statics about the structure of a file: cases, and how rows are told.


Rows = list[tuple[str, Mapping[str, Any]]]

AS = click.option(
    "--format", "form", type=click.Choice(["text", "csv", "json"]), default="text", help="How it is written."
)


def told(rows: Rows, form: str, extra: Sequence[Mapping[str, Any]] = ()) -> None:
    """Write what is to be read by programs."""
    if form == "csv":
        write_data(table_csv(rows), "csv")
    elif form == "json":
        cases: dict[str, dict[str, Any]] = {}
        for one in extra:
            cases[one["case"]] = {**one, "rows": []}
        for name, row in rows:
            cases.setdefault(name, {"case": name, "rows": []})["rows"].append(dict(row))
        write_data(json.dumps({"format": FORMAT, "cases": list(cases.values())}, indent=2) + "\n", "json")


# `stackdsl suggest`: what would let a scenario stand that falls, each answer tried by a verdict.


@click.command("suggest")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@AS
@click.pass_context
def suggest_command(context: click.Context, file: Path, systems: tuple[str, ...], keyword: str, form: str) -> None:
    """Find what would let FILE stand that falls: shifts, counterweights, friction, props; each is tried."""
    gathered, selected = selected_of(file, Selection(systems, keyword))
    rows: Rows = []
    try:
        for name, case in variants_of(selected).items():
            _suggest_case(name, case, form, rows)
    finally:  # an interruption keeps what is known
        told(rows, form)
    context.exit(code_without_runs(gathered, selected))


def _suggest_case(name: str, case: Case, form: str, rows: Rows) -> None:
    proofs = proofs_of(case.timeline)
    verdict = proofs.verdict
    if verdict.stability is not Stability.UNSTABLE:
        said = "is proven to stand" if verdict.stability is Stability.STABLE else f"is undecided: {verdict.reason}"
        tell(f"{name}: what statics can judge {said}, so there is nothing to mend")
        return
    if form == "text":
        write(f"{name}\n  {verdict.reason}\n")
    found = list(_found_suggestions(name, case, proofs, form, rows))
    if not found:
        tell(f"{name}: nothing was found that lets it stand")


def _found_suggestions(name: str, case: Case, proofs: Proofs, form: str, rows: Rows) -> Iterator[Suggestion]:
    """Each as it is found, when it is written down."""
    with counted(None, f"{name}: verdicts") as bar:
        for suggestion in suggestions(FallingBuild(case.timeline, proofs), piling_of(case.timeline), _ticking(bar)):
            row = suggestion_row(suggestion)
            rows.append((name, row))
            if form == "text":
                write(f"    {row['text']}\n")
            yield suggestion


def _ticking(bar: Callable[[int], None]) -> Callable[[], None]:
    turns = count(1)
    return lambda: bar(next(turns))


# `stackdsl order`: an order in which a finished structure can be built, and the least props.


MOST_ORDER_VERDICTS = 1500


@click.command("order")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@click.option("--props/--no-props", default=True, show_default=True, help="Whether bricks may be propped for a while.")
@click.option(
    "--most", type=click.IntRange(min=1), default=MOST_ORDER_VERDICTS, show_default=True, help="Verdicts asked in all."
)
@AS
@click.pass_context
def order_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context, file: Path, systems: tuple[str, ...], keyword: str, props: bool, most: int, form: str
) -> None:
    """Find an order in which the finished structure of FILE can be built, standing at each step, or the least props."""
    gathered, selected = selected_of(file, Selection(systems, keyword))
    rows: Rows = []
    orders: list[dict[str, Any]] = []
    interrupted = False
    for name, case in variants_of(selected).items():
        found = finished_structure_of(case.timeline)
        if found.why_not:
            tell(f"{name}: {found.why_not}")
            continue
        if found.left_out:
            tell(f"{name}: {how_many(found.left_out, 'brick')} left to the engine, and left out here")
        order, interrupted = _searched(name, found.assembly, props, most)
        if form == "text":
            write("\n".join([name, *order_lines(order, interrupted)]) + "\n")
        rows += [(name, row) for row in order_rows(order)]
        orders.append({"case": name, **_summary(order), "interrupted": interrupted})
        if interrupted:
            break
    told(rows, form, orders)
    context.exit(ExitCode.INTERRUPTED if interrupted else code_without_runs(gathered, selected))


def _summary(order: BuildingOrder) -> dict[str, Any]:
    return {"impossible": order.impossible, "props": list(order.props), "props_at_least": order.props_at_least}


def _searched(name: str, design: Assembly, props: bool, most: int) -> tuple[BuildingOrder, bool]:
    """The best order that is found, and whether the search was interrupted."""
    most = max(most, len(design.bricks))
    with counted(most, f"{name}: parts") as known:
        search = OrderSearch(Subsets(design, props_of(design) if props else None), most, known)
        try:
            return search.run(), False
        except KeyboardInterrupt:
            return search.best, True


# `stackdsl pull`: which bricks can be pulled out of what stands, how many one after the other, how soon it falls.


MOST_PULL_VERDICTS = 5000


@click.command("pull")
@ONE_FILE
@ON_SYSTEMS
@ON_KEYWORD
@click.option("--all", "all_bricks", is_flag=True, help="Orders may also take bricks that carry nothing.")
@click.option("--single", is_flag=True, help="Pull each brick by itself only, and look for no orders.")
@click.option(
    "--most",
    type=click.IntRange(min=1),
    default=MOST_PULL_VERDICTS,
    show_default=True,
    help="Verdicts asked for each order.",
)
@AS
@click.pass_context
def pull_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    systems: tuple[str, ...],
    keyword: str,
    all_bricks: bool,
    single: bool,
    most: int,
    form: str,
) -> None:
    """Tell which bricks of the finished structure of FILE can be pulled, and how many one after the other."""
    gathered, selected = selected_of(file, Selection(systems, keyword))
    rows: Rows = []
    orders: list[dict[str, Any]] = []
    try:
        for name, case in variants_of(selected).items():
            _pull_case(name, case, (all_bricks, single, most, form), rows, orders)
    finally:  # an interruption keeps what is known
        told(rows, form, orders)
    context.exit(code_without_runs(gathered, selected))


def _pull_case(
    name: str, case: Case, how: tuple[bool, bool, int, str], rows: Rows, orders: list[dict[str, Any]]
) -> None:
    all_bricks, single, most, form = how
    found = finished_structure_of(case.timeline)
    if found.why_not:
        tell(f"{name}: {found.why_not}")
        return
    if found.left_out:
        tell(f"{name}: {how_many(found.left_out, 'brick')} left to the engine, and left out here")
    _one_at_a_time(name, found.assembly, form == "text", rows)
    may_go = list(found.assembly.bricks) if all_bricks else carrying(found.assembly)
    if may_go and not single:
        orders.append({"case": name})
        _one_after_the_other(found.assembly, may_go, most, form == "text", orders[-1])


def _one_at_a_time(name: str, design: Assembly, show: bool, rows: Rows) -> None:
    pulls: list[Pull] = []
    try:
        with counted(len(design.bricks), f"{name}: pulls") as known:
            for pull in single_pulls(design):
                pulls.append(pull)
                known(len(pulls))
    finally:
        rows += [(name, pull_row(pull)) for pull in pulls]
        if show and pulls:
            write("\n".join([name, *pull_lines(pulls)]) + "\n")


def _one_after_the_other(
    design: Assembly, bricks: Sequence[BodyId], most: int, show: bool, row: dict[str, Any]
) -> None:
    """Look for orders, and add them to a row."""
    parts = Subsets(design)
    may_go = parts.part_of(bricks)
    with counted(most, f"{row['case']}: orders") as known:
        search = LongestSearch(parts, may_go, most, known)
        try:
            search.run()
        finally:  # an interruption keeps the best by then
            longest = search.best
            row |= {"longest": list(longest.order), "at_most": longest.at_most, "proven": longest.proven}
            if show:
                write("\n".join(longest_lines(longest)) + "\n")
        parts.asked = 0
        soonest = soonest_fall(parts, may_go, most, known)
    row |= {"falls_soonest": list(soonest.order), "falls_at_least": soonest.at_least}
    if show:
        write(soonest_line(soonest) + "\n")
