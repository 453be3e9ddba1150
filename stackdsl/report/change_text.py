"""One observation of two runs as one line."""

from stackdsl.observations import Change, Seen
from stackdsl.report.outcome_text import significant

MOST_NAMES = 6  # that are written out
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
            more = len(value) - MOST_NAMES
            names = value if more <= 1 else (*value[:MOST_NAMES], f"{more} more")
            return ", ".join(names) or NOTHING
        case _:
            return value or NOTHING
