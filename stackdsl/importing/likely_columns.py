"""Which column of a table a header may mean that is none: its author is asked, nothing is guessed."""

import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Final

LIKE: Final[Mapping[str, Sequence[str]]] = {
    "name": ("id", "label", "box", "item", "carton", "sku", "no", "nr", "number", "key"),
    "length": ("l", "len", "dx", "sx", "lx", "sizex"),
    "width": ("w", "depth", "d", "breadth", "b", "dy", "sy", "ly", "sizey"),
    "height": ("h", "dz", "sz", "lz", "thickness", "sizez"),
    "mass": ("weight", "wt", "load", "kg"),
    "x": ("posx", "px", "cx", "xpos", "left"),
    "y": ("posy", "py", "cy", "ypos", "front"),
    "z": ("posz", "pz", "cz", "zpos", "bottom", "level"),
    "friction": ("mu", "cof"),
    "yaw": ("rotation", "rot", "angle", "orientation", "theta", "turn"),
}
UNIT: Final = re.compile(r"[\[(/].*|_(?:mm|cm|m|in|g|kg|t|lb|deg)$", re.IGNORECASE)


def likely_column(header: str) -> str:
    """The column that a header seems to be meant as; empty where nothing says so."""
    word = re.sub(r"[^a-z]", "", UNIT.sub("", header.strip()).lower())
    named = next((column for column, words in LIKE.items() if word in words), "")
    close = get_close_matches(word, [column for column in LIKE if len(column) > 1], n=1, cutoff=0.75)
    return named or (close[0] if close else "")
