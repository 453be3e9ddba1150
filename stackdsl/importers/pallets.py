"""Reads pallets of BED-BPP and pallet-sim."""

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Final

from stackdsl.importers.load import Deck, ImportedBox, ImportedLoad, LoadReading
from stackdsl.importers.text_positions import JsonText, Node, Numeral, UnitReader, chosen, json_text

# Packing plans of BED-BPP: for each order the items in the sequence in which they are placed.
#
# `flb_coordinates` are those of the front, left, bottom corner in mm; `orientation` 1 lays length along y and width
# along x. Sizes and weights are keys with their units, such as `length/mm` and `weight/kg`.


_SIDES: Final = ("length/mm", "width/mm", "height/mm")
_OF_ITEM: Final = {"article", "product_group", "sequence"}


def read_bed_bpp(reading: LoadReading, load: str | None) -> ImportedLoad:
    """The items of one packing plan. Raises UnreadableLoadError."""
    json = json_text(reading)
    found = chosen(json, json.mapping(json.root, "the packing plans"), load, "order", json.root)
    if found is None:
        return reading.load(())
    order, plan = found
    measures = UnitReader(reading, Fraction(1, 1000))
    items = json.items(plan, f"the plan of order '{order}'")
    made = [_bed_bpp_box(json, node, number, measures) for number, node in enumerate(items, start=1)]
    return reading.load([box for box in made if box is not None])


def _bed_bpp_box(json: JsonText, node: Node, number: int, measures: UnitReader) -> ImportedBox | None:
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


def _corner(json: JsonText, node: Node | None, measures: UnitReader) -> tuple[Fraction, Fraction, Fraction] | None:
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


# Orders of the package `pallet-sim`: pallets of boxes, and the articles in them.
#
# Lengths are in mm and masses in g; `anchor` is the lower corner of a box, and `dimension` is that of the box as it
# lies. The deck of the pallet is the ground, and `palletDimension` its size.


_OF_ORDER: Final = {"orderID"}
_OF_PALLET: Final = {"palletType"}
_OF_BOX: Final = {"approach", "rgb", "weight"}  # the latter two are those of the article
_OF_ARTICLE: Final = {"description", "shippingGroup", "rgb"}


def read_pallet_sim(reading: LoadReading, load: str | None) -> ImportedLoad:
    """The boxes of one pallet of an order. Raises UnreadableLoadError."""
    json = json_text(reading)
    order = json.mapping(json.root, "the order")
    json.pass_over(order, {"pallets", "articles"}, _OF_ORDER)
    measures = UnitReader(reading, Fraction(1, 1000), Fraction(1, 1000))
    masses = _masses(json, json.member(json.root, order, "articles", "the order"), measures)
    pallets = json.member(json.root, order, "pallets", "the order")
    found = chosen(json, _pallets(json, pallets), load, "pallet", pallets) if pallets else None
    if found is None:
        return reading.load(())
    _, pallet = found
    members = json.mapping(pallet, "the pallet")
    json.pass_over(members, {"palletNr", "boxes", "palletDimension"}, _OF_PALLET)
    boxes = json.member(pallet, members, "boxes", "the pallet")
    items = json.items(boxes, "`boxes`") if boxes else []
    made = [_pallet_sim_box(json, box, number, masses, measures) for number, box in enumerate(items, start=1)]
    deck = _deck(json, members.get("palletDimension"), measures)
    return replace(reading.load([box for box in made if box is not None]), deck=deck)


def _deck(json: JsonText, node: Node | None, measures: UnitReader) -> Deck | None:
    """The deck that a pallet says it has, from whose corner on its boxes are measured; None if it says none."""
    if node is None:
        return None
    members = json.mapping(node, "`palletDimension`")
    json.pass_over(members, {"x", "y"}, {"z"})
    sides = [json.member(node, members, axis, "`palletDimension`") for axis in "xy"]
    size = measures.deck(json, sides, "`palletDimension`")
    return Deck(size) if size is not None else None


def _pallets(json: JsonText, pallets: Node) -> Mapping[str, Node]:
    """The pallets of an order by their numbers."""
    found: dict[str, Node] = {}
    for pallet in json.items(pallets, "`pallets`"):
        number = json.member(pallet, json.mapping(pallet, "the pallet"), "palletNr", "the pallet")
        name = json.word(number, "`palletNr`") if number else None
        if name in found and number:
            json.reading.wrong(json.span(number), f"two pallets have the number '{name}'", "number them apart")
        if name is not None:
            found.setdefault(name, pallet)
    return found


def _masses(json: JsonText, articles: Node | None, measures: UnitReader) -> Mapping[str, Fraction | None]:
    """The mass of each article; None where it is wrong, which is told."""
    found: dict[str, Fraction | None] = {}
    for code, article in json.mapping(articles, "`articles`").items() if articles else ():
        members = json.mapping(article, f"article '{code}'")
        json.pass_over(members, {"weight"}, _OF_ARTICLE)
        weight = json.member(article, members, "weight", f"article '{code}'")
        found[code] = measures.weight(json, weight, f"weight of article '{code}'")
    return found


def _pallet_sim_box(
    json: JsonText, node: Node, number: int, masses: Mapping[str, Fraction | None], measures: UnitReader
) -> ImportedBox | None:
    box = json.mapping(node, "the box")
    json.pass_over(box, {"product_code", "anchor", "dimension"}, _OF_BOX)
    corner = _three(json, node, box, "anchor", measures, side=False)
    size = _three(json, node, box, "dimension", measures, side=True)
    code = json.member(node, box, "product_code", "the box")
    article = json.word(code, "`product_code`") if code else None
    if code and article is not None and article not in masses:
        json.reading.wrong(json.span(code), f"there is no article '{article}'", "complete `articles`")
    mass = masses.get(article) if article is not None else None
    if corner is None or size is None or mass is None:
        return None
    x, y, z = (low + side / 2 for low, side in zip(corner, size, strict=True))
    return ImportedBox(f"box-{number}", size, (x, y, z), mass, json.span(node))


def _three(  # noqa: PLR0913, PLR0917 -- a value, and where it comes from
    json: JsonText, owner: Node, box: dict[str, Node], key: str, measures: UnitReader, side: bool
) -> tuple[Fraction, Fraction, Fraction] | None:
    node = json.member(owner, box, key, "the box")
    if node is None:
        return None
    members = json.mapping(node, f"`{key}`")
    json.pass_over(members, {"x", "y", "z"}, set())
    parts = [json.member(node, members, axis, f"`{key}`") for axis in "xyz"]
    return measures.places(json, parts, f"`{key}`", side)
