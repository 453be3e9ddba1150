"""One event of a run as one line."""

from stackdsl.trace import Event

MOST_NAMES = 6  # more bricks than this are counted, not named


def event_text(event: Event) -> str:
    """Time, what happened, to which bricks, and why."""
    names = ", ".join(event.bricks[:MOST_NAMES])
    more = f" and {len(event.bricks) - MOST_NAMES} more" if len(event.bricks) > MOST_NAMES else ""
    reason = f": {event.reason}" if event.reason else ""
    return f"{event.time:9.3f} s  {event.kind.value:<9}  {names}{more}{reason}"
