"""Why a run came out otherwise than expected, in a few lines."""

from collections.abc import Iterator

from stability.statics.solvers.fall_side import FallSide
from stackdsl.outcome import Why
from stackdsl.report.side_text import side_text


def why_lines(why: Why) -> Iterator[str]:
    """A line for each thing that is known."""
    told = {
        "cause": cause_text(why),
        "after": why.before,
        "first": why.first,
        "see": why.see,
    }
    yield from (f"  {name:<5}  {text}" for name, text in told.items() if text)


def cause_text(why: Why) -> str:
    """The cause and its side, on one line; empty where it is not known."""
    return ", ".join(filter(None, [why.cause, side_text(FallSide(why.bearing, why.overhang))]))
