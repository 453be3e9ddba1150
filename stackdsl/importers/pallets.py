"""Reads pallets of BED-BPP and pallet-sim."""

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Final

from stackdsl.importers.load import Deck, ImportedBox, ImportedLoad, LoadReading
from stackdsl.importers.text_positions import JsonText, Node, Numeral, UnitReader, json_text, select_load

# Packing plans of BED-BPP: the items of each order, in the sequence of their placement.
#
# `flb_coordinates` is the front left bottom corner in mm. With `orientation` 1, the length is along y and the width
# along x. The keys of sizes and weights contain their units, such as `length/mm` and `weight/kg`.


_SIDES: Final = ("length/mm", "width/mm", "height/mm")
_OF_ITEM: Final = {"article", "product_group", "sequence"}


def read_bed_bpp(reading: LoadReading, load: str | None) -> ImportedLoad:
    """Read the items of one packing plan. Raises UnreadableLoadError."""
    json = json_text(reading)
    selected = select_load(json, json.mapping(json.root, "the packing plans"), load, "order", json.root)
    if selected is None:
        return reading.load(())
    order, plan = selected
    units = UnitReader(reading, Fraction(1, 1000))
    items = json.items(plan, f"the plan of order '{order}'")
    boxes = [_bed_bpp_box(json, node, number, units) for number, node in enumerate(items, start=1)]
    return reading.load([box for box in boxes if box is not None])


def _bed_bpp_box(json: JsonText, node: Node, number: int, units: UnitReader) -> ImportedBox | None:
    action = json.mapping(node, "the action")
    json.skip_others(action, {"item", "flb_coordinates", "orientation"}, set())
    owner = json.member(node, action, "item", "the action")
    item = json.mapping(owner, "`item`") if owner else {}
    json.skip_others(item, {"id", *_SIDES, "weight/kg"}, _OF_ITEM)
    sides = [json.member(owner, item, key, "`item`") if owner else None for key in _SIDES]
    size = units.coordinates(json, sides, "`item`", side=True)
    weight = json.member(owner, item, "weight/kg", "`item`") if owner else None
    mass = units.mass_of(json, weight, "`weight/kg`")
    corner = _corner(json, json.member(node, action, "flb_coordinates", "the action"), units)
    swapped = _is_swapped(json, json.member(node, action, "orientation", "the action"))
    if size is None or mass is None or corner is None or swapped is None:
        return None
    laid = (size[1], size[0], size[2]) if swapped else size
    x, y, z = (low + side / 2 for low, side in zip(corner, laid, strict=True))
    return ImportedBox(f"item-{number}", laid, (x, y, z), mass, json.span(node))


def _corner(json: JsonText, node: Node | None, units: UnitReader) -> tuple[Fraction, Fraction, Fraction] | None:
    if node is None:
        return None
    parts = json.items(node, "`flb_coordinates`")
    if len(parts) != 3:  # noqa: PLR2004 -- x, y and z
        if isinstance(node.value, list):
            json.reading.wrong(
                json.span(node), f"`flb_coordinates` has {len(parts)} numbers instead of three", "write three numbers"
            )
        return None
    return units.coordinates(json, parts, "`flb_coordinates`")


def _is_swapped(json: JsonText, node: Node | None) -> bool | None:
    """Return whether the length of an item is along y; None if the orientation is missing or invalid."""
    if node is None:
        return None
    if isinstance(node.value, Numeral) and node.value.text in {"0", "1"}:
        return node.value.text == "1"
    json.reading.wrong(json.span(node), "`orientation` must be 0 or 1", "rotate items about the vertical axis only")
    return None


# Orders of the package `pallet-sim`: pallets of boxes, and the articles in them.
#
# Lengths are in mm and masses in g. `anchor` is the lower corner of a box, and `dimension` its size in its orientation
# on the pallet. The deck of the pallet is the ground, and `palletDimension` its size.


_OF_ORDER: Final = {"orderID"}
_OF_PALLET: Final = {"palletType"}
_OF_BOX: Final = {"approach", "rgb", "weight"}  # `rgb` and `weight` repeat those of the article
_OF_ARTICLE: Final = {"description", "shippingGroup", "rgb"}


def read_pallet_sim(reading: LoadReading, load: str | None) -> ImportedLoad:
    """Read the boxes of one pallet of an order. Raises UnreadableLoadError."""
    json = json_text(reading)
    order = json.mapping(json.root, "the order")
    json.skip_others(order, {"pallets", "articles"}, _OF_ORDER)
    units = UnitReader(reading, Fraction(1, 1000), Fraction(1, 1000))
    masses = _masses(json, json.member(json.root, order, "articles", "the order"), units)
    pallets = json.member(json.root, order, "pallets", "the order")
    selected = select_load(json, _pallets(json, pallets), load, "pallet", pallets) if pallets else None
    if selected is None:
        return reading.load(())
    _, pallet = selected
    members = json.mapping(pallet, "the pallet")
    json.skip_others(members, {"palletNr", "boxes", "palletDimension"}, _OF_PALLET)
    boxes = json.member(pallet, members, "boxes", "the pallet")
    items = json.items(boxes, "`boxes`") if boxes else []
    read = [_pallet_sim_box(json, box, number, masses, units) for number, box in enumerate(items, start=1)]
    deck = _deck(json, members.get("palletDimension"), units)
    return replace(reading.load([box for box in read if box is not None]), deck=deck)


def _deck(json: JsonText, node: Node | None, units: UnitReader) -> Deck | None:
    """Return the deck of a pallet, whose corner is the origin of its boxes; None if it gives no size."""
    if node is None:
        return None
    members = json.mapping(node, "`palletDimension`")
    json.skip_others(members, {"x", "y"}, {"z"})
    sides = [json.member(node, members, axis, "`palletDimension`") for axis in "xy"]
    size = units.deck(json, sides, "`palletDimension`")
    return Deck(size) if size is not None else None


def _pallets(json: JsonText, pallets: Node) -> Mapping[str, Node]:
    """Return the pallets of an order by number."""
    by_number: dict[str, Node] = {}
    for pallet in json.items(pallets, "`pallets`"):
        number = json.member(pallet, json.mapping(pallet, "the pallet"), "palletNr", "the pallet")
        name = json.word(number, "`palletNr`") if number else None
        if name in by_number and number:
            json.reading.wrong(
                json.span(number), f"two pallets have the number '{name}'", "give each a different number"
            )
        if name is not None:
            by_number.setdefault(name, pallet)
    return by_number


def _masses(json: JsonText, articles: Node | None, units: UnitReader) -> Mapping[str, Fraction | None]:
    """Return the mass of each article [kg]; report invalid ones and return None for them."""
    masses: dict[str, Fraction | None] = {}
    for code, article in json.mapping(articles, "`articles`").items() if articles else ():
        members = json.mapping(article, f"article '{code}'")
        json.skip_others(members, {"weight"}, _OF_ARTICLE)
        weight = json.member(article, members, "weight", f"article '{code}'")
        masses[code] = units.mass_of(json, weight, f"weight of article '{code}'")
    return masses


def _pallet_sim_box(
    json: JsonText, node: Node, number: int, masses: Mapping[str, Fraction | None], units: UnitReader
) -> ImportedBox | None:
    box = json.mapping(node, "the box")
    json.skip_others(box, {"product_code", "anchor", "dimension"}, _OF_BOX)
    corner = _vector(json, node, box, "anchor", units, side=False)
    size = _vector(json, node, box, "dimension", units, side=True)
    code = json.member(node, box, "product_code", "the box")
    article = json.word(code, "`product_code`") if code else None
    if code and article is not None and article not in masses:
        json.reading.wrong(json.span(code), f"`articles` has no entry '{article}'", "add it")
    mass = masses.get(article) if article is not None else None
    if corner is None or size is None or mass is None:
        return None
    x, y, z = (low + side / 2 for low, side in zip(corner, size, strict=True))
    return ImportedBox(f"box-{number}", size, (x, y, z), mass, json.span(node))


def _vector(  # noqa: PLR0913, PLR0917 -- a value and its position in the file
    json: JsonText, owner: Node, box: dict[str, Node], key: str, units: UnitReader, side: bool
) -> tuple[Fraction, Fraction, Fraction] | None:
    node = json.member(owner, box, key, "the box")
    if node is None:
        return None
    members = json.mapping(node, f"`{key}`")
    json.skip_others(members, {"x", "y", "z"}, set())
    parts = [json.member(node, members, axis, f"`{key}`") for axis in "xyz"]
    return units.coordinates(json, parts, f"`{key}`", side)
