"""Systems of other packages, found by their entry points in the group `stackdsl.systems` (docs/own-engine.md).

An entry point has the name of its system and refers to a `System`. Errors in an entry point are reported in one line.
"""

from collections.abc import Iterable, Iterator, Sequence
from importlib.metadata import EntryPoint
from importlib.util import find_spec
from inspect import getsource
from pkgutil import resolve_name
from typing import Final

from stability.engines.bodies import EngineWorld
from stability.engines.protocol import EngineSettings, Package, World
from stackdsl.diagnostics import meant_choice
from stackdsl.entry_points import GROUP, PluginError, engine_remedy, offered_systems
from stackdsl.simulation.systems import PEERS, SYSTEMS, System


class ForeignSystemError(PluginError):
    """A system of another package cannot be used; the message names it, the reason and the remedy, in one line."""


class UnknownSystemError(ForeignSystemError, KeyError):
    """No system, of this or of another package, has the requested name."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name

    def __str__(self) -> str:
        """Return the name, a name that may be meant, and all names."""
        if remedy := engine_remedy(self.name):
            listed = "" if self.name.lower() in PEERS else "; the scenario must list it, too, as in `systems: [tuned]`"
            return f"'{self.name}' is an engine, not a system; {remedy}{listed}"
        known, others = [*SYSTEMS, *PEERS], [*offered_systems()]
        meant = meant_choice(self.name, [*known, *others])
        hint = f" (did you mean '{meant}'?)" if meant else ""
        plugins = f"systems of plug-ins: {', '.join(others)}" if others else "no plug-in with systems is installed"
        return (
            f"unknown system '{self.name}'{hint}; known systems: {', '.join(known)}; {plugins}; `stackdsl doctor` "
            "lists plug-ins that failed to load"
        )


def foreign_names() -> tuple[str, ...]:
    """Return the names of all systems of other packages, without loading any.

    Raises ForeignSystemError if one of them has the name of a system of this package.
    """
    for name in {**SYSTEMS, **PEERS}.keys() & offered_systems().keys():
        package = _packages(*offered_systems()[name])
        raise ForeignSystemError(
            f"{package} offers a system with the name '{name}', which stackdsl reserves; uninstall {package}"
        )
    return tuple(offered_systems())


def foreign_system(name: str) -> System:
    """Load and return a system of another package.

    Raises UnknownSystemError if there is none of that name, and ForeignSystemError if it cannot be used.
    """
    if name not in foreign_names():
        raise UnknownSystemError(name)
    entry, *others = offered_systems()[name]
    if others:
        raise ForeignSystemError(
            f"{_packages(entry, *others)} offer systems with the same name '{name}'; uninstall all but one"
        )
    system = _loaded(entry)
    for mistake in _mistakes(entry, system):
        raise ForeignSystemError(f"{_offer(entry)} cannot be used: {mistake}")
    assert isinstance(system, System)
    return system


def usable_and_not() -> tuple[list[System], list[ForeignSystemError]]:
    """Load all systems of other packages; return those that can be used, and the errors of the others.

    The class of the worlds is imported, too, if the package of the engine is installed.
    """
    usable, errors = list[System](), list[ForeignSystemError]()
    try:
        names = foreign_names()
    except ForeignSystemError as error:
        return [], [error]
    for name in names:
        try:
            system = foreign_system(name)
            if system.engine.package.installed:
                world_class(system)
            usable.append(system)
        except ForeignSystemError as error:
            errors.append(error)
    return usable, errors


def world_class(system: System) -> object:
    """Import and return the class of the worlds of a system from another package. Raises ForeignSystemError."""
    entry, *_ = offered_systems()[system.name]
    settings, named = type(system.engine).__name__, system.engine.world
    remedy = f"set `world` of {settings} to 'MODULE:CLASS'"
    try:
        worlds = resolve_name(named)
    except (Exception, SystemExit) as error:  # importing another package may raise anything
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise ForeignSystemError(
            f"{_offer(entry)} cannot be used: the class of its worlds, {named}, cannot be loaded: {reason}; {remedy}"
        ) from error
    if not callable(getattr(worlds, "opened", None)):
        raise ForeignSystemError(
            f"{_offer(entry)} cannot be used: its worlds, {named}, have no class method `opened`"
            f"{_meant('opened', worlds)}; add `{OPENED}`, or {remedy}"
        )
    if isinstance(worlds, type) and issubclass(worlds, EngineWorld):
        complain_of_missing(system, worlds)
    return worlds


def complain_of_missing(system: System, world: object) -> None:
    """Raise ForeignSystemError if a world, or a class of worlds, lacks an attribute."""
    names = [name for name in REQUIRED if name not in SET_BY_INSTANCE or not isinstance(world, type)]
    if missing := [name for name in names if getattr(world, name, None) is None]:
        entry, *_ = offered_systems()[system.name]
        kind = world if isinstance(world, type) else type(world)
        lacks = f"{kind.__name__} lacks {_missing_text(missing, kind)}"
        raise ForeignSystemError(f"{_offer(entry)} cannot be used: {lacks}; see docs/own-engine.md")


def _missing_text(missing: Sequence[str], kind: type) -> str:
    """Return missing attributes of a class of worlds in words, and how to add them."""
    names = ", ".join(f"`{name}`{_meant(name, kind)}" for name in missing)
    own = [name for name in missing if not hasattr(EngineWorld, name)]
    remedies = [f"add {', '.join(f'`{_head(name)}`' for name in own)}"] if own else []
    if len(own) < len(missing):
        remedies.append(f"derive it from {EngineWorld.__module__}.EngineWorld")
    return f"{names}; {', and '.join(remedies)}"


def _meant(name: str, kind: object) -> str:
    """Return a hint at an attribute of a class of worlds that may be a slip of a missing one."""
    meant = meant_choice(name, [other for other in dir(kind) if not other.startswith("_") and other not in REQUIRED])
    return f" (rename `{meant}`?)" if meant else ""


def _head(name: str) -> str:
    """Return the first line of a method of a world."""
    method = getattr(World, name)
    if isinstance(method, property):
        return f"self.{name}"
    return getsource(method).partition(":\n")[0].strip()


REQUIRED: Final = tuple(name for name in dir(World) if not name.startswith("_"))
SET_BY_INSTANCE: Final = ("settings",)
OPENED: Final = "@classmethod def opened(cls, settings, gravity, friction, heaviest=None) -> World"


def distributions_of(names: Iterable[str]) -> tuple[str, ...]:
    """The distributions that bring those of some systems that come with other packages, each once."""
    entries = (offered_systems()[name][0] for name in sorted({*names} & offered_systems().keys()))
    return tuple(dict.fromkeys(entry.dist.name for entry in entries if entry.dist is not None))


def packages_text(system: str) -> str:
    """Return name and version of the package that offers a system."""
    entry = offered_systems()[system][0] if system in offered_systems() else None
    return f"{entry.dist.name} {entry.dist.version}" if entry is not None and entry.dist is not None else "a package"


def _loaded(entry: EntryPoint) -> object:
    try:
        return entry.load()
    except (Exception, SystemExit) as error:  # importing another package may raise anything
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        message = f"{_offer(entry)} cannot be loaded: {reason}; {_remedy(entry, error)}"
        raise ForeignSystemError(message) from error


def _remedy(entry: EntryPoint, error: BaseException) -> str:
    """Return what to change after an error of an import."""
    module = entry.module.partition(".")[0]
    if isinstance(error, ModuleNotFoundError) and error.name and error.name.partition(".")[0] != module:
        return f"install {error.name}, or import it only in the module of the world"
    if isinstance(error, ModuleNotFoundError):
        return f"correct the module in pyproject.toml, add it to the modules of the package, and {AGAIN}"
    if isinstance(error, AttributeError) and find_spec(module) is not None:
        return f"define `{entry.attr}` in {entry.module}, or correct pyproject.toml and {AGAIN}"
    return f"correct {entry.module}; python -c 'import {entry.module}' shows the traceback"


AGAIN = "install the package again"


def _mistakes(entry: EntryPoint, system: object) -> Iterator[str]:
    """Yield every error in the object that an entry point of the group `stackdsl.systems` refers to."""
    if not isinstance(system, System):
        yield (
            f"{entry.value} is of type {type(system).__name__}, but must be a stackdsl.simulation.systems.System; "
            f"let the entry point refer to a System, and {AGAIN}"
        )
    elif system.name != entry.name:
        yield (
            f"its name is '{system.name}', but must be the name of its entry point in {GROUP}; rename one of them, "
            f"and {AGAIN}"
        )
    elif not isinstance(system.engine, EngineSettings):
        kind = type(system.engine).__name__
        yield f"its engine is of type {kind}, but must be a stability.engines.protocol.EngineSettings"
    else:
        yield from _settings_mistakes(system.engine)


def _settings_mistakes(settings: EngineSettings) -> Iterator[str]:
    kind = type(settings)
    package, world, step = (getattr(settings, name, None) for name in ("package", "world", "time_step"))
    if not isinstance(package, Package):
        add = "package: ClassVar[Package] = Package('IMPORT_NAME', 'pip install NAME')"
        yield f"{kind.__name__} has no `package`; add: {add}"
    if not isinstance(world, str) or ":" not in world:
        yield f"{kind.__name__} has no `world`; add: world: ClassVar[str] = 'MODULE:CLASS'"
    if not isinstance(step, int | float) or not step > 0.0:
        yield f"`time_step` of {kind.__name__} is {step!r}, but must be a positive number of seconds"


def _offer(entry: EntryPoint) -> str:
    return f"the system '{entry.name}' of {_packages(entry)} (entry point {entry.name} = {entry.value})"


def _packages(*entries: EntryPoint) -> str:
    return " and ".join(entry.dist.name if entry.dist is not None else "a package" for entry in entries)
