"""Orders of `pallet-sim` are read as the package's own reader gives them to PyBullet."""

import pytest

from benchmarks.pallet_orders import DECK, folder, orders, read_by_package
from stackdsl.importers.formats import read_load
from stackdsl.language.imports import Import

FEW = 3  # the benchmark compares all


@pytest.mark.skipif(folder() is None, reason="pallet-sim is not installed")
def test_boxes_are_where_the_package_sets_them_above_its_deck() -> None:
    for order in list(orders())[:FEW]:
        for (number, _), (_, *theirs) in zip(order.pallets(), read_by_package(order), strict=True):
            asked = Import.model_validate({"file": order.name, "format": "pallet-sim", "load": number})
            ours = read_load(order.data, order.name, asked).boxes
            assert len(ours) == len(theirs)
            for box, other in zip(ours, theirs, strict=True):
                x, y, z = other["basePosition"]
                assert tuple(map(float, box.centre)) == pytest.approx((x, y, z - DECK), abs=1e-9)
                assert [float(side) / 2 for side in box.size] == pytest.approx(other["halfExtents"], abs=1e-9)
                assert float(box.mass) == pytest.approx(other["baseMass"] / 1000)
