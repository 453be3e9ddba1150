"""What a structure survives by bearing, as text, CSV and JSON."""

import csv
import io
from collections.abc import Iterator, Sequence
from itertools import groupby
from math import degrees, inf
from typing import Any

from stability.statics.margins.acceleration import tilt
from stackdsl.judging.survival import Along, Survival
from stackdsl.report.weakest_text import weakest_json, weakest_text

FORMAT = 1  # of the JSON; raised when something in it changes its meaning
COLUMNS = ("bearing_deg", "survives_g", "fails_g", "tilt_deg", "gives_way")


def survival_lines(name: str, survival: Survival) -> Iterator[str]:
    """One line where the same gives way, and the number for all bearings."""
    yield name
    worst = survival.worst
    if worst.survived == inf:
        yield "  survives every acceleration, in every direction: it is held on all sides"
        return
    first = survival.weakest
    if first is None:
        yield (
            f"  survives {worst.survived:.4g} g along these bearings, which is a tilt of {degrees(worst.tilt):.4g} deg;"
            f" least towards {degrees(worst.bearing):.4g} deg"
        )
    else:
        told = degrees(tilt(first.acceleration))
        yield f"  survives {first.acceleration:.4g} g in every direction, which is a tilt of {told:.4g} deg"
        yield f"  {weakest_text(first)}"
    for rows in _alike(survival.along):
        yield f"  {_span(rows):>20}  {_range([row.survived for row in rows]):>16} g  {rows[0].gives_way}".rstrip()


def _alike(along: Sequence[Along]) -> list[list[Along]]:
    """Neighbours at which the same gives way; those around +x come first, as one."""
    runs = [list(rows) for _, rows in groupby(along, key=lambda each: each.gives_way)]
    if len(runs) > 1 and runs[0][0].gives_way == runs[-1][0].gives_way:
        runs = [[*runs[-1], *runs[0]], *runs[1:-1]]
    return runs


def _span(rows: Sequence[Along]) -> str:
    first, last = (f"{degrees(row.bearing):.4g}" for row in (rows[0], rows[-1]))
    return f"towards {first} deg" if len(rows) == 1 else f"{first} to {last} deg"


def _range(values: Sequence[float]) -> str:
    least, most = f"{min(values):.4g}", f"{max(values):.4g}"
    return least if least == most else f"{least} .. {most}"


def survival_csv(survivals: Sequence[tuple[str, Survival]]) -> str:
    """A row a bearing; nothing stands where nothing gives way."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(("case", *COLUMNS))
    for name, survival in survivals:
        for each in survival.along:
            writer.writerow((name, *("" if value is None else value for value in _row(each).values())))
    return out.getvalue()


def survival_json(survivals: Sequence[tuple[str, Survival]]) -> dict[str, Any]:
    """The same as JSON; `null` where nothing gives way."""
    cases = [
        {
            "case": name,
            "survives_g": _finite((survival.weakest and survival.weakest.acceleration) or survival.worst.survived),
            "weakest": None if survival.weakest is None else weakest_json(survival.weakest),
            "bearings": [*map(_row, survival.along)],
        }
        for name, survival in survivals
    ]
    return {"format": FORMAT, "cases": cases}


def _row(each: Along) -> dict[str, float | str | None]:
    numbers = (degrees(each.bearing), each.survived, each.fails, degrees(each.tilt))
    return dict(zip(COLUMNS, (*map(_finite, numbers), each.gives_way), strict=True))


def _finite(value: float) -> float | None:
    return None if value == inf else float(f"{value:.6g}")
