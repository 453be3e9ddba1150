"""Commands on the statics of one file: `survive`, `find`, `sensitivities`, `suggest`, `order`, `pull`."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import count
from math import tan

import click

from stability.analysis.building_order import OrderSearch
from stability.analysis.removal_order import LongestSearch, Pull, carrying, single_pulls, soonest_fall
from stability.analysis.subset_search import Subsets, props_of
from stability.model import BodyId
from stability.problem import Stability, Verdict
from stability.statics.assembly import Assembly
from stability.work_limit import TooMuchWorkError
from stackdsl.checking.cases import Case
from stackdsl.cli.one_file import IN_PARTS, Parts, Request, Writing, draw, refuse_several, statics_command
from stackdsl.cli.options import Number
from stackdsl.cli.terminal import counted, tell
from stackdsl.exits import ExitCode
from stackdsl.judging.judge import expected_of
from stackdsl.judging.proofs import Proofs, Survival, fall_apart, finished_structure_of, piling_of, proofs_of
from stackdsl.judging.remedies import FallingBuild, suggestions
from stackdsl.language.claims.margin import Margin
from stackdsl.language.quantities import ANGLE, InputError, parse_quantity
from stackdsl.report.statics import missed_lines
from stackdsl.report.studies import (
    after_text,
    limit_lines,
    limit_table,
    longest_lines,
    order_lines,
    order_rows,
    pull_lines,
    pull_row,
    sensitivity_lines,
    sensitivity_table,
    soonest_line,
    suggestion_row,
    survival_lines,
    survival_table,
)
from stackdsl.report.study_table import Part
from stackdsl.studies import survival
from stackdsl.studies.find_limit import (
    ACCURACY,
    FINEST,
    FoundLimit,
    LimitRequest,
    Want,
    find_in,
    is_shaken,
)
from stackdsl.studies.limit_search import SearchError
from stackdsl.studies.sensitivities import CHECKED, MarginKind, Sensitivities, sensitivities_so_far
from stackdsl.timeline import leaves_to_engine
from stackdsl.viewing.plots import drawn_survival
from stackdsl.wording import GAPS, apart_text, how_many

# `stackdsl survive`: acceleration and tilt that a structure survives, by bearing, and the part that fails first.


SURVIVAL = Writing[tuple[str, Survival]](lambda each: survival_lines(*each), survival_table)


@statics_command("survive", plot=True)
@click.option(
    "--bearings",
    type=click.IntRange(survival.FEWEST_BEARINGS, survival.MOST_BEARINGS),
    default=survival.BEARINGS,
    show_default=True,
    help="Number of directions, evenly spaced.",
)
@click.option(
    "--accuracy",
    type=Number(survival.FINEST, survival.COARSEST),
    default=survival.ACCURACY,
    show_default=True,
    help="Relative accuracy.",
)
def survive_command(request: Request, bearings: int, accuracy: float) -> ExitCode:
    """Compute the acceleration and tilt that the structure of FILE survives, and the part that fails first."""
    cases = request.variants()
    refuse_several(request.plot, len(cases))
    questions = ((name, _survival(name, case, bearings, accuracy)) for name, case in cases.items())
    found, code = request.answer(questions, SURVIVAL, "use fewer --bearings or fewer bricks")
    if request.plot is not None and found and not found[0][1].along:
        tell(f"{found[0][0]}: no plot is drawn, as accelerations are not computed for bricks with joints")
    elif request.plot is not None and found:
        name, worst = found[0]
        draw(partial(drawn_survival, name, worst, expected=_expected(cases[name])), request.plot)
    return _unless_nothing(found, code)


def _expected(case: Case) -> float | None:
    """Return the least acceleration that the scenario expects to be survived [g], also as a tilt; None without one."""
    claims = (claim.content for _, claim in expected_of(case.scenario, case.system))
    margins = [content for content in claims if isinstance(content, Margin)]
    limits = [margin.acceleration.low for margin in margins if margin.acceleration is not None]
    limits += [tan(max(margin.tilt.low, 0.0)) for margin in margins if margin.tilt is not None]
    return max((limit for limit in limits if limit > 0.0), default=None)


def _survival(name: str, case: Case, bearings: int, accuracy: float) -> Iterator[tuple[str, Survival]]:
    """Yield the accelerations that a case survives; report why they are unknown, and what is not judged."""
    try:
        with counted(bearings, f"{name}: bearings") as known:
            found = survival.survive_in(case, name, bearings, accuracy, known)
    except SearchError as error:
        tell(f"{name}: {error}")
    else:
        for note in found.notes:
            tell(f"{name}: {note}")
        yield name, found


# `stackdsl find`: the largest or the least value with which a scenario stands, with proofs on both sides.


USUALLY = 60  # usual number of tried values, for the progress bar
LIMITS = Writing[FoundLimit](limit_lines, limit_table)


def _bearing(context: click.Context, parameter: click.Parameter, value: str | None) -> float | None:
    try:
        return None if value is None else parse_quantity(value, ANGLE)
    except InputError as mistake:
        raise click.BadParameter(f"{mistake.message}; {mistake.hint}", context, parameter) from mistake


@statics_command("find")
@click.option("--largest", metavar="NAME", multiple=True, help="Find the largest value of this number.")
@click.option("--least", metavar="NAME", multiple=True, help="Find the least value of this number.")
@click.option("--most", metavar="NAME", multiple=True, help="Find the largest value of this whole number.")
@click.option("--from", "low", metavar="VALUE", default="", help="Lower end of the search.")
@click.option("--to", "high", metavar="VALUE", default="", help="Upper end of the search.")
@click.option(
    "--within",
    "accuracy",
    type=Number(FINEST, 0.5),
    default=ACCURACY,
    show_default=True,
    help="Relative distance between both sides of the limit.",
)
@click.option(
    "--bearing", callback=_bearing, metavar="ANGLE", help="Direction of a tilt or an acceleration. Default: the worst."
)
def find_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    request: Request,
    largest: tuple[str, ...],
    least: tuple[str, ...],
    most: tuple[str, ...],
    low: str,
    high: str,
    accuracy: float,
    bearing: float | None,
) -> ExitCode:
    """Find the largest or least value with which FILE stands, proven on both sides and without simulation."""
    wanted = [*((Want.LARGEST, name) for name in largest), *((Want.LEAST, name) for name in least)]
    wanted += [(Want.MOST, name) for name in most]
    if not wanted:
        raise click.UsageError("no number to find; add, for example, --largest step, --least friction or --most levels")
    wishes = [LimitRequest(want, name.strip(), low, high, accuracy, bearing) for want, name in wanted]
    questions = (
        (name, _limit(name, case, wish)) for wish in wishes for name, case in request.variants(wish.name).items()
    )
    instead = "narrow the range with --from and --to, use a larger --within, or use fewer bricks"
    return _unless_nothing(*request.answer(questions, LIMITS, instead))


def _unless_nothing(found: Sequence[object], code: ExitCode) -> ExitCode:
    """Return the exit code of a command whose question has no answer for any case, or else `code`."""
    return ExitCode.USAGE if code is ExitCode.OK and not found else code


def _limit(name: str, case: Case, wish: LimitRequest) -> Iterator[FoundLimit]:
    """Yield the limit of a case; report why there is none, and what is not judged."""
    if not is_shaken(case, wish.name) and any(map(leaves_to_engine, case.timeline.as_set_down().actions)):
        what = "a brick that is pushed, shaken, moved, dropped or thrown"
        tell(f"{name}: judged up to the first action that needs an engine, such as {what}")
    try:
        with counted(USUALLY, f"{name}: {wish.want} {wish.name}") as tried:
            found = find_in(case, name, wish, tried)
    except SearchError as error:
        tell(f"{name}: {error}")
    else:
        yield found


# `stackdsl sensitivities`: bricks, joints and numbers on which the margin of a structure depends most.


SHOWN = 15


@statics_command("sensitivities")
@click.option(
    "--of",
    type=click.Choice([each.value for each in MarginKind]),
    default=MarginKind.ACCELERATION.value,
    help="Margin to analyse.",
)
@click.option(
    "--check",
    "checked",
    type=click.IntRange(0),
    default=CHECKED,
    show_default=True,
    help="Number of results to verify by finite differences.",
)
@click.option("--top", type=click.IntRange(1), default=SHOWN, show_default=True, help="Number of lines of text.")
def sensitivities_command(request: Request, of: str, checked: int, top: int) -> ExitCode:
    """List the bricks, joints and numbers on which the margin of FILE depends most."""
    writing = Writing[Sensitivities](lambda each: sensitivity_lines(each, top), sensitivity_table)
    questions = (
        (name, _sensitivities(name, case, MarginKind(of), checked)) for name, case in request.variants().items()
    )
    return _unless_nothing(
        *request.answer(questions, writing, "use --check 0, which checks no result, or fewer bricks")
    )


def _sensitivities(name: str, case: Case, of: MarginKind, checked: int) -> Iterator[Sensitivities]:
    """Yield the sensitivities of a case, also of an interrupted study; report why there are none."""
    found: Callable[[], Sensitivities] | None = None
    stopped: BaseException | None = None
    try:
        with counted(100, f"{name}: percent") as known:
            for so_far in sensitivities_so_far(
                case, name, of, checked, lambda done, total: known(round(100 * done / total))
            ):
                found = so_far
    except SearchError as error:
        tell(f"{name}: {error}")
    except (KeyboardInterrupt, TooMuchWorkError) as error:
        stopped = error
    if found is not None:
        yield found()
    if stopped is not None:
        raise stopped


# `stackdsl suggest`: changes with which a falling scenario stands, each verified by a verdict.


SHIFTS = frozenset({"shift", "shifts"})
FURTHER = "each shift is the least: shift further, and measure the margin with `stackdsl survive` on the changed file"


@statics_command("suggest")
def suggest_command(request: Request) -> ExitCode:
    """Find changes that let a falling FILE stand: shifts, counterweights, friction, props. Each is verified."""
    questions = ((name, _suggestions(name, case)) for name, case in request.variants().items())
    return request.answer(questions, IN_PARTS, "use a part of the build or fewer bricks")[1]


def _why_no_repair(verdict: Verdict) -> str:
    """Return why no changes are searched; empty if the structure is proven to stand or to fall."""
    if verdict.stability is Stability.UNDECIDED:
        return f"it is undecided whether it stands ({verdict.reason}), so there is nothing to repair"
    return ""


def _suggestions(name: str, case: Case) -> Parts:
    proofs = proofs_of(case.timeline)
    verdict = proofs.verdict
    if hopeless := _why_no_repair(verdict):
        tell(f"{name}: {hopeless}")
        return
    if verdict.stability is Stability.STABLE:
        missed, fall = [*missed_lines(case, proofs.assembly)], fall_apart(proofs.assembly)
        if missed:
            yield Part(name, [f"{name} is proven to stand, but misses a margin:", *missed])
        if fall is not None:
            yield Part(name, [f"{name}: {apart_text(fall)}", f"  {GAPS}"])
        if not missed and fall is None:
            tell(f"{name} is proven to stand, so there is nothing to repair")
        if any(map(leaves_to_engine, case.timeline.as_set_down().actions)):
            tell(f"{name}: judged up to the first action that needs an engine, such as a hit or shaking")
        return
    yield Part(name, [f"{name} falls: {verdict.reason}"])
    yield from _repairs(name, case, proofs)


def _repairs(name: str, case: Case, proofs: Proofs) -> Parts:
    """Yield the changes with which a falling build stands."""
    kinds = set[str]()
    with counted(None, f"{name}: verdicts") as bar:
        build = FallingBuild(case.timeline, proofs)
        for suggestion in suggestions(build, piling_of(case.timeline), _ticking(bar)):
            row = suggestion_row(suggestion)
            if not kinds:
                yield Part(name, ["  it stands with any one of these (each tried):"])
            kinds.add(row["kind"])
            least = "; it then just stands" * (row["kind"] in SHIFTS)
            yield Part(name, [f"    {row['text']}{least}"], [row])
    if kinds & SHIFTS:
        yield Part(name, [f"  {FURTHER}"])
    if not kinds:
        tell(f"{name}: no change was found with which it stands")


def _ticking(bar: Callable[[int], None]) -> Callable[[], None]:
    turns = count(1)
    return lambda: bar(next(turns))


# `stackdsl order`: an order of building a finished structure, and the fewest props.


MOST_ORDER_VERDICTS = 1500
LESS = "use a smaller --most or fewer bricks"


@statics_command("order")
@click.option("--props/--no-props", default=True, show_default=True, help="Allow temporary props.")
@click.option(
    "--most",
    type=click.IntRange(min=1),
    default=MOST_ORDER_VERDICTS,
    show_default=True,
    help="Largest number of verdicts.",
)
def order_command(request: Request, props: bool, most: int) -> ExitCode:
    """Find an order of building in which the structure of FILE stands after each step, or the fewest props."""
    questions = ((name, _order(name, case, props, most)) for name, case in request.variants().items())
    return _unless_nothing(*request.answer(questions, IN_PARTS, LESS))


def _finished(name: str, case: Case) -> Assembly | None:
    """Return the finished structure of a case, or None; report the reason and omitted bricks."""
    found = finished_structure_of(case.timeline)
    if found.why_not:
        tell(f"{name}: {found.why_not}")
        return None
    if found.left_out:
        tell(f"{name}: {how_many(found.left_out, 'brick')} left out, since they depend on the engine")
    return found.assembly


def _order(name: str, case: Case, props: bool, most: int) -> Parts:
    """Yield the best building order found, also by an interrupted search."""
    design = _finished(name, case)
    if design is None:
        return
    stopped: BaseException | None = None
    with counted(most := max(most, len(design.bricks)), f"{name}: parts") as known:
        search = OrderSearch(Subsets(design, props_of(design) if props else None), most, known)
        try:
            order = search.run()
        except (KeyboardInterrupt, TooMuchWorkError) as error:
            order, stopped = search.best, error
    told = {"impossible": order.impossible, "props": list(order.props), "props_at_least": order.props_at_least}
    yield Part(
        name,
        list(order_lines(name, order, stopped is not None)),
        list(order_rows(order)),
        {**told, "interrupted": stopped is not None},
    )
    if stopped is not None:
        raise stopped


# `stackdsl pull`: removable bricks of a standing structure, the longest order of pulls, and the fewest that fell it.


MOST_PULL_VERDICTS = 5000


@statics_command("pull")
@click.option("--all", "all_bricks", is_flag=True, help="Orders may also pull bricks that carry nothing.")
@click.option("--single", is_flag=True, help="Pull each brick by itself only, without a search for orders.")
@click.option(
    "--most",
    type=click.IntRange(min=1),
    default=MOST_PULL_VERDICTS,
    show_default=True,
    help="Largest number of verdicts for each order.",
)
def pull_command(request: Request, all_bricks: bool, single: bool, most: int) -> ExitCode:
    """List the bricks that can be pulled out of the structure of FILE, and the longest order of pulls."""
    how = all_bricks, not single, most
    questions = ((name, _pulls(name, case, *how)) for name, case in request.variants().items())
    return _unless_nothing(*request.answer(questions, IN_PARTS, LESS))


def _pulls(name: str, case: Case, all_bricks: bool, orders: bool, most: int) -> Parts:
    design = _finished(name, case)
    if design is None:
        return
    yield from _one_at_a_time(name, design, after_text(case.timeline))
    may_go = list(design.bricks) if all_bricks else carrying(design)
    if may_go and orders:
        yield from _one_after_the_other(name, design, may_go, most)


def _one_at_a_time(name: str, design: Assembly, after: str) -> Parts:
    pulls: list[Pull] = []
    stopped: BaseException | None = None
    try:
        with counted(len(design.bricks), f"{name}: pulls") as known:
            for pull in single_pulls(design):
                pulls.append(pull)
                known(len(pulls))
    except (KeyboardInterrupt, TooMuchWorkError) as error:
        stopped = error
    if pulls:
        yield Part(name, list(pull_lines(name, after, pulls)), [pull_row(pull) for pull in pulls])
    if stopped is not None:
        raise stopped


def _one_after_the_other(name: str, design: Assembly, bricks: Sequence[BodyId], most: int) -> Parts:
    """Yield the orders of removals found, also by an interrupted search."""
    parts = Subsets(design)
    may_go = parts.part_of(bricks)
    stopped: BaseException | None = None
    with counted(most, f"{name}: orders") as known:
        search = LongestSearch(parts, may_go, most, known)
        try:
            search.run()
        except (KeyboardInterrupt, TooMuchWorkError) as error:
            stopped = error
        longest = search.best
        told = {"longest": list(longest.order), "at_most": longest.at_most, "proven": longest.proven}
        yield Part(name, list(longest_lines(longest)), whole=told)
        if stopped is not None:
            raise stopped
        parts.verdict_count = 0
        soonest = soonest_fall(parts, may_go, most, known)
    told = {"falls_soonest": list(soonest.order), "falls_at_least": soonest.at_least}
    yield Part(name, [soonest_line(soonest)], whole=told)
