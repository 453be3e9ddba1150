"""What settling changed, in words."""

from collections.abc import Iterator, Sequence
from fractions import Fraction

from stackdsl.importing.settling import Settled
from stackdsl.importing.written_load import digits


def moved_lines(settled: Settled) -> Iterator[str]:
    """A line for each kind of change, with the box that it changed most."""
    boxes = settled.load.boxes
    names = [box.name or f"the box of line {box.span.line}" for box in boxes]
    lowered, raised = [max(-way, Fraction(0)) for way in settled.moved], [max(w, Fraction(0)) for w in settled.moved]
    changes = {"lowered": lowered, "raised": raised, "taken as higher": settled.grown}
    for done, ways in {**changes, "taken as shorter sideways": settled.trimmed}.items():
        if any(ways):
            yield _line(done, ways, names)
    if not any(any(ways) for ways in (*changes.values(), settled.trimmed)):
        yield f"none of {len(boxes)} boxes was moved"


def _line(done: str, ways: Sequence[Fraction], names: Sequence[str]) -> str:
    most = max(ways)
    count = sum(way > 0 for way in ways)
    what = f"{count} of {len(ways)} boxes {'was' if count == 1 else 'were'} {done}"
    return f"{what}, {names[list(ways).index(most)]} most: by {digits(1000 * most)} mm"
