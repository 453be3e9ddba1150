"""What to say of contacts that an engine gave a wrong normal."""

from collections.abc import Iterable, Iterator
from math import degrees

from stackdsl.outcome import VariantResult
from stackdsl.trace import Collapse, WrongEdges


def wrong_edges_text(wrong: WrongEdges, collapse: Collapse | None) -> str:
    """How many, which one most, when and by how much, and what that leaves in doubt."""
    worst = f"{wrong.upper} on {wrong.lower}, {degrees(wrong.angle):.0f} deg off at {wrong.time:.1f} s"
    contacts = f"1 contact ({worst})" if wrong.contacts == 1 else f"{wrong.contacts} contacts (worst: {worst})"
    return f"wrong edge normals in {contacts}; {_doubt(wrong, collapse)}"


def wrong_edges(results: Iterable[VariantResult]) -> Iterator[str]:
    """A line for each run that had some."""
    for result in results:
        if result.wrong_edges is not None:
            yield f"{result.name}: {wrong_edges_text(result.wrong_edges, result.collapse)}"


def _doubt(wrong: WrongEdges, collapse: Collapse | None) -> str:
    """What was seen only after a collapse cannot have caused it."""
    if collapse is not None and wrong.first > collapse.time:
        return "where this debris comes to lie is not to be trusted"
    return "unless proven, whether these bricks stand or fall is not to be trusted"
