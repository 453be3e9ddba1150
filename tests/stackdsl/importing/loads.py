"""Small files of each format, and other readers of them, which know nothing of ours."""

import csv
import json
from fractions import Fraction
from typing import Any, Final, TypeAlias

Box: TypeAlias = tuple[tuple[float, ...], tuple[float, ...], float]  # size, centre [m], mass [kg]

TABLE: Final = """name,length [mm],width [mm],height [cm],mass [g],x [m],y [m],z [m]
bottom,400,300,20,5200,0,0,0
"by side",400,300,20.0,5.2e3,0.4,0,0
top,600,300,10.5,800,0.1,0,0.2
""".replace('"by side"', "by-side")

PALLET: Final = json.dumps(
    {
        "orderID": "1",
        "pallets": [
            {
                "palletNr": "001",
                "palletType": "EURO_PALLET",
                "palletDimension": {"x": 800.0, "y": 1200.0},
                "boxes": [
                    {
                        "product_code": code,
                        "anchor": dict(zip("xyz", anchor, strict=True)),
                        "dimension": dict(zip("xyz", size, strict=True)),
                        "approach": "3",
                    }
                    for code, anchor, size in (
                        ("7", (0.0, 0.0, 0.0), (394.0, 596.0, 140.0)),
                        ("7", (394.0, 0.0, 0.0), (394.0, 596.0, 140.0)),
                        ("8", (200.0, 0.0, 140.0), (388.0, 299.0, 110.0)),
                    )
                ],
            }
        ],
        "articles": {
            "7": {"description": "soap", "weight": 2600.0, "shippingGroup": "G1"},
            "8": {"description": "salt", "weight": 8400.0, "shippingGroup": "G2"},
        },
    },
    indent=1,
)

PLAN: Final = json.dumps(
    {
        "00100408": [
            {
                "item": {
                    "article": f"article-{number}",
                    "id": f"id{number}",
                    "product_group": "food",
                    "length/mm": 300,
                    "width/mm": 200,
                    "height/mm": 100,
                    "weight/kg": 3.14,
                    "sequence": number,
                },
                "flb_coordinates": corner,
                "orientation": turned,
            }
            for number, (corner, turned) in enumerate((([0, 0, 0], 0), ([300, 0, 0], 1), ([0, 0, 100], 1)), start=1)
        ]
    },
    indent=1,
)

TEXTS: Final = {"table": TABLE, "pallet-sim": PALLET, "bed-bpp": PLAN}


def read_otherwise(format_: str, text: str) -> list[Box]:
    """The boxes of a file that is right, by the libraries for CSV and JSON alone. Raises if it is not."""
    if format_ == "table":
        return [_row(row) for row in csv.DictReader(text.splitlines(), strict=True)]
    whole = json.loads(text, object_pairs_hook=_each_once)
    if format_ == "bed-bpp":
        (actions,) = whole.values()
        return [_action(action) for action in actions]
    (pallet,) = whole["pallets"]
    return [_of_pallet(box, whole["articles"]) for box in pallet["boxes"]]


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    assert len(dict(pairs)) == len(pairs)
    return dict(pairs)


def _row(row: dict[str | None, Any]) -> Box:
    assert None not in row
    assert None not in row.values()
    per: dict[str, Fraction | int] = {"mm": 1000, "cm": 100, "m": 1, "g": 1000, "kg": 1, "t": Fraction(1, 1000)}
    by: dict[str, Any] = {}
    for header, cell in row.items():
        name, _, unit = str(header).rstrip("] ").partition("[")
        by[name.strip()] = cell if name.strip() == "name" else Fraction(cell) / per[unit.strip()]
    return _box([by[key] for key in "xyz"], [by[key] for key in ("length", "width", "height")], by["mass"])


def _of_pallet(box: dict[str, Any], articles: dict[str, Any]) -> Box:
    corner = [_exact(box["anchor"][axis]) / 1000 for axis in "xyz"]
    size = [_exact(box["dimension"][axis]) / 1000 for axis in "xyz"]
    return _box(corner, size, _exact(articles[box["product_code"]]["weight"]) / 1000)


def _action(action: dict[str, Any]) -> Box:
    item = action["item"]
    size = [_exact(item[f"{side}/mm"]) / 1000 for side in ("length", "width", "height")]
    assert action["orientation"] in {0, 1}
    laid = [size[1], size[0], size[2]] if action["orientation"] == 1 else size
    return _box([_exact(part) / 1000 for part in action["flb_coordinates"]], laid, _exact(item["weight/kg"]))


def _exact(number: float) -> Fraction:
    assert isinstance(number, int | float)
    assert not isinstance(number, bool)
    return Fraction(repr(number))


def _box(corner: list[Fraction], size: list[Fraction], mass: Fraction) -> Box:
    assert min(*size, mass) > 0
    centre = tuple(float(low + side / 2) for low, side in zip(corner, size, strict=True))
    return tuple(map(float, size)), centre, float(mass)
