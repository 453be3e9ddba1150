"""Words of new users for round bricks, and the entries that they mean."""

import re
from collections.abc import Mapping
from typing import Final

# Words for the shape of a brick -> key of the shape.
ROUND_WORDS: Final[Mapping[str, str]] = {
    **dict.fromkeys(("cylinder", "can", "barrel", "drum", "log", "disc", "disk", "roller", "rod"), "cylinder"),
    **dict.fromkeys(("cone", "frustum", "bucket"), "cone"),
    **dict.fromkeys(("pipe", "tube", "ring"), "pipe"),
    **dict.fromkeys(("sphere", "ball", "marble"), "sphere"),
    **dict.fromkeys(("capsule", "pill"), "capsule"),
}
SHAPE_WORDS: Final = ("shape", "type", "kind", "form", "geometry", "primitive")  # keys that others use for a shape
ROUND_LENGTHS: Final = ("radius", "diameter")
LENGTHS_ALONG: Final = ("height", "length", "h", "thickness", "depth")
_USUAL: Final = "30 mm"  # diameter in examples
_TALL: Final = "60 mm"
_QUANTITY: Final = re.compile(r"(\d+(?:\.\d*)?)\s*([a-z]+)")


def round_word(written: object) -> str:
    """Return the word for a round shape that a value is, or that is the first key of a mapping; empty if neither."""
    word = next(iter(written), None) if isinstance(written, dict) else written
    return word if isinstance(word, str) and word in ROUND_WORDS else ""


def twice(length: object) -> str:
    """Return twice a length of a scenario, such as `15 mm` or `${r}`; empty if it is neither."""
    if isinstance(length, str) and (quantity := _QUANTITY.fullmatch(length.strip())):
        return f"{2.0 * float(quantity[1]):g} {quantity[2]}"
    if isinstance(length, str) and length.startswith("${") and length.endswith("}"):
        return f'"${{2 * ({length[2:-1].strip()})}}"'
    return ""


def round_entry(word: str, written: object = None) -> str:
    """Return the entry of a round brick, such as `sphere: {diameter: 30 mm}`.

    Lengths are taken from what an author wrote: a diameter, or a mapping with a radius, a diameter or a height.
    """
    shape = ROUND_WORDS[word]
    lengths = written if isinstance(written, dict) else {"diameter": written}
    across = twice(lengths.get("radius")) or (_quoted(lengths.get("diameter")) or _USUAL)
    along = (_quoted(lengths[key]) for key in LENGTHS_ALONG if _quoted(lengths.get(key)))
    tall = "" if shape == "sphere" else f", height: {next(along, _TALL)}"
    wall = f", wall: {_quoted(lengths.get('wall')) or '2 mm'}" if shape == "pipe" else ""
    return f"{shape}: {{{'bottom' if shape == 'cone' else 'diameter'}: {across}{wall}{tall}}}"


def _quoted(length: object) -> str:
    """Return a length as it stands in YAML; empty if it is no text."""
    text = length if isinstance(length, str) else ""
    return f'"{text}"' if text.startswith("$") else text


def round_brick(word: str, written: object = None) -> str:
    """Return the mapping of a round brick with its shape and its density or mass."""
    heavy = written if isinstance(written, dict) else {}
    weights = (f"{key}: {heavy[key]}" for key in ("mass", "density") if isinstance(heavy.get(key), str))
    weight = next(weights, "density: 500 kg/m3")
    return f"{{{round_entry(word, written)}, {weight}}}"
