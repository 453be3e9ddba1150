"""A world of the engine that settings are of. The engine is imported here, when something must be stepped."""

from pkgutil import resolve_name
from typing import TypeVar

from stability.engines.protocol import OpensWorlds, World
from stability.engines.settings import EngineSettings
from stability.friction_law import GivenFriction

Settings = TypeVar("Settings", bound=EngineSettings)


def load_engine(settings: EngineSettings) -> None:
    """Import the engine that these are settings of."""
    _worlds_of(settings)


def stepped_world(settings: EngineSettings, gravity: float, friction: GivenFriction, heaviest: float) -> World:
    """An empty world of the engine that these are settings of; close it after use.

    Gravity [m/s2] is along -z, friction that of brick on brick, `heaviest` the mass of the heaviest brick to come [kg].
    """
    return _worlds_of(settings).opened(settings, gravity, friction, heaviest)


def _worlds_of(settings: Settings) -> OpensWorlds[Settings]:
    worlds: OpensWorlds[Settings] = resolve_name(settings.world)
    return worlds
