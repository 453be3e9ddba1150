"""Pulls and building orders as text; the rows of their tables are the same for CSV and JSON."""

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from stability.statics.facts import Stability
from stability.statics.orders.building import BuildingOrder
from stability.statics.orders.pulls import Longest, Pull, Soonest

FORMAT = 1  # of the JSON; raised when something in it changes its meaning
ANSWERS = {Stability.STABLE: "stands", Stability.UNSTABLE: "falls", Stability.UNDECIDED: "not proven"}


def pull_row(pull: Pull) -> dict[str, Any]:
    """One brick that was pulled out of the whole."""
    verdict = pull.verdict
    why = verdict.reason or (f"{verdict.stage}" if verdict.stage is not None else "")
    return {"brick": pull.brick, "carries": pull.carries, "rest": ANSWERS[verdict.stability], "proof": why}


def pull_lines(pulls: Sequence[Pull]) -> Iterator[str]:
    """How many can be pulled, and each with its proof."""
    counts = {answer: sum(p.verdict.stability is answer for p in pulls) for answer in ANSWERS}
    told = ", ".join(f"{count} {ANSWERS[answer]}" for answer, count in counts.items() if count)
    yield f"  pulled one at a time, the rest: {told}"
    width = max(len(pull.brick) for pull in pulls)
    for row in map(pull_row, pulls):
        over = "" if row["carries"] else ", carries nothing"
        yield f"    {row['brick']:<{width}}  {row['rest']}{': ' * bool(row['proof'])}{row['proof']}{over}"


def longest_lines(longest: Longest) -> Iterator[str]:
    """The longest order of pulls."""
    if longest.proven:
        bound = "no order is longer, which is proven"
    else:
        bound = f"no order is longer than {longest.at_most}, which is proven"
        bound += f" ({longest.reason})" if longest.reason else ""
    yield f"  longest order of pulls with the rest standing each time: {len(longest.order)}; {bound}"
    if longest.order:
        yield f"    {', '.join(longest.order)}"


def soonest_line(soonest: Soonest) -> str:
    """The worst case."""
    if not soonest.order:
        return (
            f"  no {soonest.at_least - 1} pulls bring it down" if soonest.at_least > 1 else "  no worst case was found"
        )
    count = len(soonest.order)
    fewest = "no fewer do, which is proven" if soonest.at_least == count else "fewer were not all proven"
    return f"  it falls soonest with {count} pull{'s' * (count != 1)}: {', '.join(soonest.order)}; {fewest}"


def order_rows(order: BuildingOrder) -> list[dict[str, Any]]:
    """A row a step."""
    return [
        {"step": n, "brick": step.brick, "prop": step.propped, "struck": " ".join(step.struck)}
        for n, step in enumerate(order.steps, 1)
    ]


def order_lines(order: BuildingOrder, interrupted: bool = False) -> Iterator[str]:
    """An order, and how many props it needs; if it was interrupted, the best by then."""
    unpropped = order.without is not None and order.without.order is not None
    if interrupted:
        yield "  interrupted: this is what was known by then"
    if not order.steps:
        if order.impossible:
            yield "  none exists, which is proven"
        elif order.props_at_least:
            yield f"  none was found; one needs at least {order.props_at_least} props, which is proven"
        else:
            yield "  none was found, and that there is none is not proven"
        return
    if unpropped:
        yield f"  all {len(order.steps)} bricks can be set down one at a time, without props"
    else:
        yield from _props(order, interrupted)
    yield from _steps(order)


def _props(order: BuildingOrder, interrupted: bool) -> Iterator[str]:
    proven = order.without is not None and order.without.impossible
    yield f"  no order without props {'exists, which is proven' if proven else 'was found'}"
    count = len(order.props)
    least = "proven" if order.props_at_least == count else f"at least {order.props_at_least} are needed"
    what = "props so far" if interrupted else "least props"
    yield f"  {what}: {count} in all ({least}), of which {order.props_at_once} stand at a time"


def _steps(order: BuildingOrder) -> Iterator[str]:
    for row in order_rows(order):
        prop = "  with a prop under it" if row["prop"] else ""
        struck = f"; then no prop under {row['struck'].replace(' ', ', ')}" if row["struck"] else ""
        yield f"  {row['step']:4}  {row['brick']}{prop}{struck}"


def table_csv(rows: Sequence[tuple[str, Mapping[str, Any]]]) -> str:
    """Rows of cases, all with the same columns."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    if rows:
        writer.writerow(("case", *rows[0][1]))
    for name, row in rows:
        writer.writerow((name, *(_plain(value) for value in row.values())))
    return out.getvalue()


def _plain(value: object) -> object:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "" if value is None else value
