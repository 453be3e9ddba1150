"""The same system at another resolution. What a finer one changes of a result was no physics."""

from dataclasses import replace

from stability.engines.settings import EngineSettings
from stackdsl.systems.systems import System


def refined(settings: EngineSettings) -> EngineSettings:
    """Half the time step and twice the iterations; all else as it was."""
    return replace(settings, time_step=0.5 * settings.time_step, iterations=2 * settings.iterations)


def at_step(settings: EngineSettings, factor: float) -> EngineSettings:
    """So many times the time step; iterations and all else as they were."""
    return replace(settings, time_step=factor * settings.time_step)


def refined_system(system: System) -> System:
    """The system with refined settings."""
    return replace(system, engine=refined(system.engine))


def system_at_step(system: System, factor: float) -> System:
    """The system with so many times its time step."""
    return replace(system, engine=at_step(system.engine, factor))
