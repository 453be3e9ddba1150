"""PyBullet behind the protocols of `stability.engines.protocol`; no code outside this package uses the engine.

`PyBulletBodies` attaches to a client that the caller runs. `PyBulletWorld` runs its own. Either of them imports the
engine; the settings do not.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stability.engines.pybullet.client import PyBulletBodies
    from stability.engines.pybullet.world import PyBulletWorld

__all__ = ["PyBulletBodies", "PyBulletWorld"]
MODULES = {"PyBulletBodies": "client", "PyBulletWorld": "world"}


def __getattr__(name: str) -> object:
    if name not in MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{MODULES[name]}"), name)
