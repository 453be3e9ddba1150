"""What limits of scenarios were found, as text, CSV and JSON."""

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from itertools import groupby
from math import ceil, inf, log10
from typing import Any, Final

from stackdsl.finding.find_limit import End, FoundLimit, Want

FORMAT = 1  # of the JSON; raised when something in it changes its meaning
DIGITS: Final = (6, 10)  # of a limit: at least and at most
NUMBERS: Final = ("stands", "beyond", "written", "low", "high")
COLUMNS: Final = (
    *("case", "want", "name", "end", "stands", "beyond", "unit", "stands_si", "beyond_si", "written", "low", "high"),
    *("by_program", "verdicts", "is_open", "judged", "bricks", "place", "why"),
)


def limit_lines(finding: FoundLimit) -> Iterator[str]:
    """What was found of one case, and how sure that is."""
    yield finding.case
    yield f"  {_limit(finding)}"
    if finding.end in (End.LIMIT, End.NOWHERE) and finding.why:
        when = "" if not finding.moment else f", when what comes at {finding.moment:g} s is set down"
        yield f"    what falls: {finding.why}{when}"
    if finding.end is End.OPEN:
        yield f"    undecided: {finding.why}"
    yield from (f"    {line}" for line in _remarks(finding))


def _limit(finding: FoundLimit) -> str:
    asked, stands = f"{finding.want} {finding.name}", _text(finding, finding.stands)
    match finding.end:
        case End.LIMIT:
            return f"{asked}: {stands} stands, {_text(finding, finding.beyond)} falls"
        case End.EDGE:
            return f"{asked}: {stands} stands, and {_text(finding, finding.beyond)} is no scenario: {finding.why}"
        case End.NONE if finding.stands == inf:
            return f"{asked}: no limit; it is held on all sides"
        case End.NONE:
            way = "down" if finding.want is Want.LEAST else "up"
            why = f"; further, {finding.why}, so say how far: --to" if finding.why else ""
            return f"{asked}: no limit was found: it stands {way} to {stands}{why}"
        case End.NOWHERE if finding.written is None:
            return f"{asked}: none, as it is not proven to stand by itself"
        case End.NOWHERE:
            return f"{asked}: none was found: it falls with all that were tried"
        case End.OPEN:
            return f"{asked}: none was found: it is proven to stand with none that was tried"
        case End.NO_EFFECT:
            return f"{asked}: has no effect on what is built"
        case _:
            return f"{asked}: nothing is set down at rest that statics could judge"


def _remarks(finding: FoundLimit) -> Iterator[str]:
    """What the limit is worth."""
    if finding.written is not None:
        where = f" at {finding.place}" if finding.place else ""
        yield f"in place of {_text(finding, finding.written)}{where}" + (f"; {finding.others}" * bool(finding.others))
    if finding.by_program and finding.written is None:
        yield "forces prove the one, a motion the other, of what is finished"
    elif finding.written is not None and finding.end is not End.NOTHING:
        how = "told by a program, and asked on both sides; " if finding.by_program else ""
        least, most = _text(finding, finding.low), _text(finding, finding.high)
        yield f"{how}{finding.verdicts} verdict{'s' * (finding.verdicts > 1)}, from {least} to {most}"
    if finding.is_open:
        yield "undecided between: it is too close to its limit to say more"
    if finding.contradicting:
        yield f"this is not the only limit: {', and '.join(_contradicting(finding))}"
    if finding.judged < finding.bricks and finding.stands is not None:
        yield f"of {finding.judged} of {finding.bricks} bricks: from there on an engine has a word, which is not asked"


def _contradicting(finding: FoundLimit) -> Iterator[str]:
    """What came of numbers that are other than on the rest of their side of the limit."""
    for answer, group in groupby(finding.contradicting, key=lambda each: each[1]):
        values = [_text(finding, value) for value, _ in group]
        ends = (
            f" with each of {len(values)} numbers from {values[0]} to {values[-1]}"
            if len(values) > 1
            else f" at {values[0]}"
        )
        yield f"it {answer} also{ends}"


def _text(finding: FoundLimit, value: float | None) -> str:
    if value is None:
        return "none"
    return f"{value:.{_digits(finding)}g} {finding.unit}".rstrip()


def _digits(finding: FoundLimit) -> int:
    """As many as tell one side of the limit from the other."""
    least, most = DIGITS
    if finding.stands is None or finding.beyond is None or finding.stands == finding.beyond:
        return least
    size = max(abs(finding.stands), abs(finding.beyond))
    return min(most, max(least, ceil(log10(size / abs(finding.stands - finding.beyond))) + 2))


def limit_csv(findings: Sequence[FoundLimit]) -> str:
    """A row a case and number."""
    out = io.StringIO()
    writer = csv.DictWriter(out, COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(map(_row, findings))
    return out.getvalue()


def limit_json(findings: Sequence[FoundLimit]) -> dict[str, Any]:
    """The same as JSON, with what contradicts; `null` where there is no number."""
    return {"format": FORMAT, "found": [*map(_row, findings)]}


def _row(finding: FoundLimit) -> dict[str, Any]:
    row = {key: value for key, value in asdict(finding).items() if key not in ("scale", "moment", "others")}
    row["contradicting"] = [{"value": value, "answer": answer} for value, answer in finding.contradicting]
    numbers = {key: _finite(row[key]) for key in NUMBERS}
    in_si = {f"{key}_si": _finite(row[key], finding.scale) for key in ("stands", "beyond")}
    return row | numbers | in_si


def _finite(value: float | None, scale: float = 1.0) -> float | None:
    return None if value is None or value == inf else scale * value
