"""What came of a sweep, as text, CSV and JSON; the rows themselves are in its file."""

import csv
import io
from collections.abc import Iterator, Sequence
from typing import Any, Final

from stackdsl.report.ensemble_text import levels_told
from stackdsl.shown_text import visible
from stackdsl.sweeping.swept import SweptCase

FORMAT: Final = 1  # of the JSON; raised when something in it changes its meaning
SAMPLED: Final = ("stands", "collapses", "undecided", "unfit", "failed")  # the verdicts of samples
COLUMNS: Final = ("case", "rows", *SAMPLED, "stands_least", "stands_most")
VERBS: Final = {
    "stands": "stand",
    "collapses": "fall",
    "unfit": "of which a brick found no place beside others",
}
FEW: Final = 3  # reasons of failures that are told


def sweep_lines(cases: Sequence[SweptCase]) -> Iterator[str]:
    """A line a case; below it how that is known, and what failed. Rows may be of whoever sent the project."""
    yield from map(visible, _lines(cases))


def _lines(cases: Sequence[SweptCase]) -> Iterator[str]:
    for each in cases:
        if not each.rows:
            continue
        if not each.entry.case.is_sampled:
            yield f"{each.entry.name}: {_once(each)}"
            continue
        yield f"{each.entry.name}: {each.rows} of {each.entry.count} samples, seed {each.entry.seed}: {_verdicts(each)}"
        if (stands := each.stands) is not None:
            sure = f"{100.0 * each.entry.case.scenario.confidence:g} % sure"
            yield f"  share that stands: {100.0 * stands.low:.4g} .. {100.0 * stands.high:.4g} %, {sure}"
        if each.ways:
            yield f"  decided: {', '.join(f'{count} {way}' for way, count in each.ways.items())}"
        failed = list(each.failed.items())
        yield from (f"  failed: {why}" + (f" ({count} of them)" if count > 1 else "") for why, count in failed[:FEW])
        if len(failed) > FEW:
            yield f"  failed: {len(failed) - FEW} more reasons, in the rows whose verdict is failed"


def sweep_csv(cases: Sequence[SweptCase]) -> str:
    """A row a case."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for each in cases:
        share = each.stands
        counts = (each.verdicts.get(verdict, 0) for verdict in SAMPLED)
        writer.writerow((each.entry.name, each.rows, *counts, *((share.low, share.high) if share else ("", ""))))
    return out.getvalue()


def sweep_json(cases: Sequence[SweptCase]) -> dict[str, Any]:
    """The same with levels and ways; no share where there are no samples."""
    return {"format": FORMAT, "cases": [_case(each) for each in cases]}


def _case(each: SweptCase) -> dict[str, Any]:
    share = each.stands
    return {
        "case": each.entry.name,
        "seed": each.entry.seed,
        "rows": each.rows,
        "planned": each.entry.count,
        "verdicts": each.verdicts,
        "fell": {str(level): count for level, count in each.fell.items()},
        "ways": each.ways,
        "failed": each.failed,
        "stands": [share.low, share.high] if share is not None else None,
    }


def _verdicts(each: SweptCase) -> str:
    parts = []
    for verdict, count in each.verdicts.items():
        levels = levels_told(each.fell) if verdict == "collapses" else ""
        parts.append(f"{count} {VERBS.get(verdict, verdict)}{levels}")
    return ", ".join(parts)


def _once(each: SweptCase) -> str:
    """What became of a case that is played once."""
    kind = next(iter(each.kinds))
    return f"{kind.verdict}{f' at level {kind.level}' if kind.level is not None else ''} ({kind.how})"
