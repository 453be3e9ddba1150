"""One event of a run as one line."""

from stackdsl.trace import Event
from stackdsl.wording import names_text


def event_text(event: Event) -> str:
    """Time, what happened, to which bricks, and why."""
    reason = f": {event.reason}" if event.reason else ""
    return f"{event.time:9.3f} s  {event.kind.value:<9}  {names_text(event.bricks, least=1)}{reason}"
