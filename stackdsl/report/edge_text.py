"""What to say of contacts that an engine gave a wrong normal."""

from math import degrees

from stackdsl.trace import WrongEdges


def wrong_edges_text(wrong: WrongEdges) -> str:
    """How many, which one most, when and by how much."""
    contacts = "1 contact" if wrong.contacts == 1 else f"{wrong.contacts} contacts, most"
    pair = f"{wrong.upper} on {wrong.lower} at {wrong.time:.1f} s by {degrees(wrong.angle):.0f} deg"
    return f"wrong edge normals in {contacts} {pair}; where these lie is not to be trusted"
