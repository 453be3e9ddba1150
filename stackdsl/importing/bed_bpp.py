"""Packing plans of BED-BPP: for each order the items in the sequence in which they are placed.

`flb_coordinates` are those of the front, left, bottom corner in mm; `orientation` 1 lays length along y and width along
x. Sizes and weights are keys with their units, such as `length/mm` and `weight/kg`.
"""

from fractions import Fraction
from typing import Final

from stackdsl.importing.json_text import JsonText, Node, Numeral, json_text
from stackdsl.importing.load import ImportedBox, ImportedLoad, LoadReading
from stackdsl.importing.measures import Measures, chosen

_SIDES: Final = ("length/mm", "width/mm", "height/mm")
_OF_ITEM: Final = {"article", "product_group", "sequence"}


def read_bed_bpp(reading: LoadReading, load: str | None) -> ImportedLoad:
    """The items of one packing plan. Raises UnreadableLoadError."""
    json = json_text(reading)
    found = chosen(json, json.mapping(json.root, "the packing plans"), load, "order", json.root)
    if found is None:
        return reading.load(())
    order, plan = found
    measures = Measures(reading, Fraction(1, 1000))
    items = json.items(plan, f"the plan of order '{order}'")
    made = [_box(json, node, number, measures) for number, node in enumerate(items, start=1)]
    return reading.load([box for box in made if box is not None])


def _box(json: JsonText, node: Node, number: int, measures: Measures) -> ImportedBox | None:
    action = json.mapping(node, "the action")
    json.pass_over(action, {"item", "flb_coordinates", "orientation"}, set())
    owner = json.member(node, action, "item", "the action")
    item = json.mapping(owner, "`item`") if owner else {}
    json.pass_over(item, {"id", *_SIDES, "weight/kg"}, _OF_ITEM)
    sides = [json.member(owner, item, key, "`item`") if owner else None for key in _SIDES]
    size = measures.places(json, sides, "`item`", side=True)
    weight = json.member(owner, item, "weight/kg", "`item`") if owner else None
    mass = measures.weight(json, weight, "`weight/kg`")
    corner = _corner(json, json.member(node, action, "flb_coordinates", "the action"), measures)
    swapped = _is_swapped(json, json.member(node, action, "orientation", "the action"))
    if size is None or mass is None or corner is None or swapped is None:
        return None
    laid = (size[1], size[0], size[2]) if swapped else size
    x, y, z = (low + side / 2 for low, side in zip(corner, laid, strict=True))
    return ImportedBox(f"item-{number}", laid, (x, y, z), mass, json.span(node))


def _corner(json: JsonText, node: Node | None, measures: Measures) -> tuple[Fraction, Fraction, Fraction] | None:
    if node is None:
        return None
    parts = json.items(node, "`flb_coordinates`")
    if len(parts) != 3:  # noqa: PLR2004 -- x, y and z
        if isinstance(node.value, list):
            json.reading.wrong(json.span(node), f"`flb_coordinates` has {len(parts)} numbers", "write three")
        return None
    return measures.places(json, parts, "`flb_coordinates`")


def _is_swapped(json: JsonText, node: Node | None) -> bool | None:
    """Whether an item lies with its length along y."""
    if node is None:
        return None
    if isinstance(node.value, Numeral) and node.value.text in {"0", "1"}:
        return node.value.text == "1"
    json.reading.wrong(json.span(node), "`orientation` is neither 0 nor 1", "turn items about the vertical only")
    return None
