"""Reads the orders of the package `pallet-sim`, also with its own reader but without its viewers."""

import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any, Final

PACKAGE: Final = "pallet_sim"
DECK: Final = 0.144  # [m] height of the pallet on which that reader places the boxes
UNUSED: Final = ("pkg_resources", "stl")  # imports of that reader for textures, which are not needed


@dataclass(frozen=True, slots=True)
class Order:
    """One order of the package."""

    name: str
    data: bytes

    def pallets(self) -> Iterator[tuple[str, bytes]]:
        """Yield the number of each pallet with an order of this pallet alone: reading all for each takes minutes."""
        whole = json.loads(self.data)
        for pallet in whole["pallets"]:
            yield pallet["palletNr"], json.dumps({**whole, "pallets": [pallet]}).encode()


def folder() -> Path | None:
    """Return the folder of the package; None if it is not installed."""
    spec = find_spec(PACKAGE)
    return Path(next(iter(spec.submodule_search_locations))) if spec and spec.submodule_search_locations else None


def orders() -> Iterator[Order]:
    """Yield all orders by number. Raises ModuleNotFoundError if the package is not installed."""
    home = folder()
    if home is None:
        raise ModuleNotFoundError("there is no pallet-sim: pip install --no-deps pallet-sim")
    for path in sorted((home / "example_data").glob("*.order.json")):
        yield Order(path.name.partition(".")[0], path.read_bytes())


def read_by_package(order: Order) -> list[list[dict[str, Any]]]:
    """Return for each pallet the bodies passed to PyBullet: the pallet, then its boxes, with masses in g."""
    found = _reader()(json_data=order.data.decode("utf-8"), texture_paths=[])
    return [found.get_model_data("pybullet", number) for number in range(len(found))]


def _reader() -> Any:  # noqa: ANN401 -- a class of the package
    """Return its class `Order`, imported alone: the whole package requires viewers that are not needed here."""
    home = folder()
    assert home is not None
    kept = {name: sys.modules.get(name) for name in (*UNUSED, PACKAGE)}
    package = ModuleType(PACKAGE)
    package.__path__ = [str(home)]
    sys.modules |= {PACKAGE: package} | {name: ModuleType(name) for name in UNUSED if find_spec_of(name) is None}
    try:
        return import_module(f"{PACKAGE}._order").Order
    finally:
        for name, module in kept.items():
            if module is None:
                sys.modules.pop(name, None)
            else:
                sys.modules[name] = module


def find_spec_of(name: str) -> object:
    """Return the location of a module; None if it is not installed."""
    return sys.modules.get(name) or find_spec(name)
