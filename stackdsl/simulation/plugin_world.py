"""World of an engine from another package. Its errors and wrong results name the package, the method and the line."""

import os
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from contextlib import AbstractContextManager, contextmanager, suppress
from math import isfinite
from traceback import walk_tb
from types import CodeType
from typing import Any, Final, cast

from stability.contact_law import GivenFriction
from stability.engines.lazy_world import stepped_world
from stability.engines.protocol import EngineSettings, World
from stability.model import BodyId, BodyState, ContactPoint
from stackdsl.entry_points import PluginError
from stackdsl.simulation.plugins import complain_of_missing, packages_text, world_class
from stackdsl.simulation.systems import System

UNIT: Final = 1e-3  # largest error of the squared length of a quaternion; engines use single precision
ON_CLOCK: Final = 1e-6  # share of a time step


class EngineFaultError(PluginError):
    """The engine of another package raised an error, or returned a wrong value."""


class PluginWorld:
    """A world that checks each call of another one, whose engine belongs to another package."""

    def __init__(self, world: object, system: System) -> None:
        complain_of_missing(system, world)
        self._world, self._system = cast(World, world), system

    def __getattr__(self, name: str) -> object:
        method = getattr(self._world, name)
        if not callable(method):
            return method

        def checked(*arguments: Any, **named: Any) -> object:  # noqa: ANN401 -- of any method
            with self._faults(name, method):
                result = method(*arguments, **named)
                if mistake := WRONG[name](result, *arguments) if name in WRONG else "":
                    raise WrongResultError(mistake)
            return result

        setattr(self, name, checked)
        return checked

    def _faults(self, name: str, method: object) -> AbstractContextManager[None]:
        return faults_of_plugin(self._system, f"{type(self._world).__name__}.{name}", method, self._world)

    def step(self, *arguments: Any) -> None:  # noqa: ANN401 -- as above
        """Step the world, which must advance its clock by the time step."""
        world = self._world
        with self._faults("step", world.step):
            before, due = world.time(), world.settings.time_step
            world.step(*arguments)
            passed = world.time() - before
            if not abs(passed - due) <= ON_CLOCK * due:
                raise WrongResultError(
                    f"it advanced the clock by {passed:g} s, but must advance it by the time step, {due:g} s; call "
                    "`self.clock.pass_step()` once in each `step`"
                )


def opened_plugin_world(
    system: System, settings: EngineSettings, gravity: float, friction: GivenFriction, heaviest: float
) -> World:
    """Open an empty world of a system from another package, with settings scaled to a scene. Raises PluginError."""
    world_class(system)
    with faults_of_plugin(system, f"{settings.world.partition(':')[2]}.opened"):
        world = stepped_world(settings, gravity, friction, heaviest)
    return cast(World, PluginWorld(world, system))


class WrongResultError(Exception):
    """A method of another package returned a wrong value; the message says what it must return."""


@contextmanager
def faults_of_plugin(system: System, call: str, method: object = None, world: World | None = None) -> Iterator[None]:
    """Report any error in the block as one of the engine of a system. Raises EngineFaultError."""
    try:
        yield
    except PluginError:
        raise
    except (Exception, SystemExit) as error:  # an engine may raise anything
        reason = str(error) if isinstance(error, WrongResultError) else error_text(error)
        place = place_in(error, {system.engine.world.partition(":")[0], type(system.engine).__module__}, method)
        where = ", ".join(filter(None, [place, _time_text(world)]))
        raise EngineFaultError(
            f"{engine_text(system)} failed in `{call}`{where and f' ({where})'}: {reason}"
        ) from error


def _time_text(world: World | None) -> str:
    """Return the time of a world in words; empty without one, or if its clock fails, too."""
    with suppress(Exception):
        return f"at {world.time():.3f} s of the run" if world is not None else ""
    return ""


def engine_text(system: System) -> str:
    """Return the name of a system of another package, with that package and its version."""
    return f"the engine of '{system.name}', from {packages_text(system.name)},"


def error_text(error: BaseException) -> str:
    """Return type and message of an error on one line."""
    return " ".join(f"{type(error).__name__}: {error}".split()).removesuffix(":")


def place_in(error: BaseException, modules: Set[str], method: object = None) -> str:
    """Return `FILE:LINE` of the innermost line of an error in the packages of these modules; empty without one.

    An error in a call from outside, such as wrong arguments, is at the definition of the method.
    """
    if isinstance(error, SyntaxError) and error.filename:
        return f"{_shown(error.filename)}:{error.lineno}"
    packages = {module.partition(".")[0] for module in modules}
    lines = [
        (frame.f_code.co_filename, line)
        for frame, line in walk_tb(error.__traceback__)
        if str(frame.f_globals.get("__name__")).partition(".")[0] in packages
    ]
    code = getattr(method, "__code__", None)
    if (
        not lines
        and isinstance(code, CodeType)
        and str(getattr(method, "__module__", "")).partition(".")[0] in packages
    ):
        lines = [(code.co_filename, code.co_firstlineno)]
    return f"{_shown(lines[-1][0])}:{lines[-1][1]}" if lines else ""


def _shown(file: str) -> str:
    """Return a path relative to the working directory if it is in that."""
    inside = os.path.relpath(file)
    return file if inside.startswith("..") else inside


# What is wrong with the result of a method; empty if nothing is.


def _states_mistake(states: object, bodies: Collection[BodyId]) -> str:
    if not isinstance(states, Mapping):
        return f"it returned {_kind(states)}, but must return a mapping of names to BodyState"
    for body in bodies:
        if not isinstance(state := states.get(body), BodyState):
            return f"it returned {_kind(state)} for '{body}', but must return a BodyState"
        place, turn = state.pose.position_W, state.pose.orientation
        velocity, spin = state.velocity_W, state.angular_velocity_W
        if not (_is_tuple(turn, 4) and all(_is_tuple(vector, 3) for vector in (place, velocity, spin))):
            vectors = f"position_W, velocity_W and angular_velocity_W of '{body}' must be tuples of 3 numbers"
            return f"{vectors}, and {QUATERNION}"
        if not isfinite(sum(place) + sum(turn) + sum(velocity) + sum(spin)):
            parts = f"position_W {_numbers(place)}, orientation {_numbers(turn)}, velocity_W {_numbers(velocity)}"
            where = f"the state of '{body}' has a number that is not finite"
            return f"{where}: {parts}, angular_velocity_W {_numbers(spin)}"
        if abs(sum(part * part for part in turn) - 1.0) > UNIT:
            return f"the orientation of '{body}' is {_numbers(turn)}, but {QUATERNION}"
    return ""


def _is_tuple(value: object, length: int) -> bool:
    """Return whether a value is a tuple of a length; arrays do not compare as tuples do."""
    return isinstance(value, tuple) and len(value) == length


QUATERNION: Final = "orientation must be a tuple (x, y, z, w) of length 1"


def _contacts_mistake(contacts: object, brick: BodyId) -> str:
    if not isinstance(contacts, Sequence):
        return f"it returned {_kind(contacts)}, but must return a sequence of ContactPoint"
    wrong = [each for each in contacts if not isinstance(each, ContactPoint)]
    return f"it returned {_kind(wrong[0])} in a sequence that must hold ContactPoint only" if wrong else ""


def _neighbours_mistake(names: object, *_: object) -> str:
    if isinstance(names, Sequence) and not isinstance(names, str) and all(isinstance(name, str) for name in names):
        return ""
    return f"it returned {_kind(names)}, but must return a sequence of the names of bodies"


WRONG: Final = {"states": _states_mistake, "contacts": _contacts_mistake, "neighbours": _neighbours_mistake}


def _kind(value: object) -> str:
    return "None" if value is None else f"a {type(value).__name__}"


def _numbers(values: Sequence[float]) -> str:
    return f"({', '.join(f'{value:.4g}' for value in values)})"
