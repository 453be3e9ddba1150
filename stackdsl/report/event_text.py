"""One event of a run as one line."""

from stability.name_order import in_order
from stackdsl.trace import Event, EventKind
from stackdsl.wording import names_text


def event_text(event: Event, all_names: bool = False) -> str:
    """Time, what happened, to which bricks, and why; with `all_names` every brick is named, however many there are."""
    bricks = event.bricks if event.kind is EventKind.PLACED else in_order(event.bricks)
    named = ", ".join(bricks) if all_names else names_text(bricks, least=1)
    reason = f": {event.reason}" if event.reason else ""
    return f"{event.time:9.3f} s  {event.kind.value:<9}  {named}{reason}"
