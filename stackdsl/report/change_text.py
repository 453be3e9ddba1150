"""One observation of two runs as one line."""

from stackdsl.observations import Change, Seen
from stackdsl.report.outcome_text import significant
from stackdsl.wording import shortened

NOTHING = "none"


def change_text(change: Change) -> str:
    """What was seen, what the other run showed, and the difference where it is a number."""
    difference = change.difference
    by = f" ({'+' if difference > 0.0 else ''}{significant(difference)} {change.unit})" if difference else ""
    return f"{change.name}: {_seen(change.before, change.unit)} -> {_seen(change.after, change.unit)}{by}"


def _seen(value: Seen, unit: str) -> str:
    match value:
        case float():
            return f"{significant(value)} {unit}"
        case tuple():
            names, more = shortened(value)
            return ", ".join((*names, *([f"{more} more"] if more else []))) or NOTHING
        case _:
            return value or NOTHING
