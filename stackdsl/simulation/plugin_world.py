"""World of an engine from another package. Its errors and wrong results name the package, the method and the line."""

import os
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from contextlib import AbstractContextManager, contextmanager, suppress
from math import dist, isfinite
from numbers import Real
from traceback import walk_tb
from types import CodeType
from typing import Any, Final, cast

from stability.contact_law import GivenFriction
from stability.engines.lazy_world import stepped_world
from stability.engines.protocol import EngineSettings, World
from stability.geometry.vectors import dot
from stability.model import AT_REST, BodyId, BodyState, Brick, ContactPoint, Plane, Pose, Vec3
from stackdsl.entry_points import PluginError
from stackdsl.simulation.plugins import complain_of_missing, packages_text, world_class
from stackdsl.simulation.systems import System

UNIT: Final = 1e-3  # largest error of the squared length of a quaternion or normal; engines use single precision
PLACED: Final = 1e-3  # largest error of a new brick's place, as a share of its smallest side
SINGLE: Final = 1e-6  # relative error of a number in single precision
PULL: Final = 1e-3  # [N/kg] rounding error of a force, some ten-thousandth of the weight
ON_CLOCK: Final = 1e-6  # share of a time step


class EngineFaultError(PluginError):
    """The engine of another package raised an error, or returned a wrong value."""


class PluginWorld:
    """A world that checks each call of another one, whose engine belongs to another package."""

    def __init__(self, world: object, system: System) -> None:
        complain_of_missing(system, world)
        self._world, self._system = cast(World, world), system
        self._planes, self._masses = dict[BodyId, Plane](), dict[BodyId, float]()  # of the bodies inside

    def __getattr__(self, name: str) -> object:
        method = getattr(self._world, name)
        if not callable(method):
            return method

        def checked(*arguments: Any, **named: Any) -> object:  # noqa: ANN401 -- of any method
            with self._faults(name, method):
                result = method(*arguments, **named)
                raise_for(self._mistake(name, result, *arguments))
            return result

        setattr(self, name, checked)
        return checked

    def _mistake(self, name: str, result: object, *arguments: Any) -> str:  # noqa: ANN401 -- of any method
        """Return what is wrong with the result of a method; empty if nothing is."""
        match name:
            case "states":
                return _states_mistake(result, *arguments)
            case "contacts":
                return _contacts_mistake(result, arguments[0], self._planes, self._masses)
            case "neighbours":
                return _neighbours_mistake(result, self._planes.keys() | self._masses)
        return ""

    def _faults(self, name: str, method: object) -> AbstractContextManager[None]:
        return faults_of_plugin(self._system, f"{type(self._world).__name__}.{name}", method, self._world)

    def add_plane(self, plane: Plane) -> None:
        """Add a plane to the world."""
        with self._faults("add_plane", self._world.add_plane):
            self._world.add_plane(plane)
        self._planes[plane.id] = plane

    def add_brick(self, brick: Brick, pose: Pose, velocity_W: Vec3 = AT_REST) -> None:
        """Add a brick to the world, which must then be in the given pose."""
        with self._faults("add_brick", self._world.add_brick):
            self._world.add_brick(brick, pose, velocity_W)
        self._masses[brick.id] = brick.mass
        with self._faults("states", self._world.states):
            states = self._world.states([brick.id])
            raise_for(_states_mistake(states, [brick.id]) or _placing_mistake(states[brick.id].pose, brick, pose))

    def remove_brick(self, brick: BodyId) -> None:
        """Remove a brick from the world."""
        with self._faults("remove_brick", self._world.remove_brick):
            self._world.remove_brick(brick)
        del self._masses[brick]

    def step(self, *arguments: Any) -> None:  # noqa: ANN401 -- as above
        """Step the world, which must advance its clock by the time step."""
        world = self._world
        with self._faults("step", world.step):
            before, due = world.time(), world.settings.time_step
            world.step(*arguments)
            passed = world.time() - before
            if not abs(passed - due) <= ON_CLOCK * due:
                raise_for(
                    f"it advanced the clock by {passed:g} s, but must advance it by the time step, {due:g} s; call "
                    "`self.clock.pass_step()` once in each `step`"
                )


def opened_plugin_world(
    system: System, settings: EngineSettings, gravity: float, friction: GivenFriction, heaviest: float
) -> World:
    """Open an empty world of a system from another package, with settings scaled to a scene. Raises PluginError."""
    worlds = world_class(system)
    opened = getattr(worlds, "opened", None)
    with faults_of_plugin(system, f"{settings.world.partition(':')[2]}.opened", getattr(opened, "__func__", opened)):
        world = cast(object, stepped_world(settings, gravity, friction, heaviest))
        raise_for("" if world is not None else "it returned None, but must return the new world; end it with `return`")
    return cast(World, PluginWorld(world, system))


class WrongResultError(Exception):
    """A method of another package returned a wrong value; the message says what it must return."""


def raise_for(mistake: str) -> None:
    """Raise WrongResultError for a mistake; an empty text is none."""
    if mistake:
        raise WrongResultError(mistake)


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


# Descriptions of invalid results of a method; empty for valid results.


def _states_mistake(states: object, bodies: Collection[BodyId]) -> str:
    if not isinstance(states, Mapping):
        return f"it returned {_kind(states)}, but must return a mapping of names to BodyState"
    for body in bodies:
        if not isinstance(state := states.get(body), BodyState):
            return f"it returned {_kind(state)} for '{body}', but must return a BodyState"
        if not isinstance(state.pose, Pose):
            return f"`pose` of '{body}' is {_kind(state.pose)}, but must be a Pose"
        place, turn = state.pose.position_W, state.pose.orientation
        velocity, spin = state.velocity_W, state.angular_velocity_W
        fields = {"position_W": place, "velocity_W": velocity, "angular_velocity_W": spin}
        for field, vector in fields.items():
            if not _is_tuple(vector, 3):
                return f"`{field}` of '{body}' is {_kind(vector)}, but must be a tuple of 3 numbers"
        if not _is_tuple(turn, 4):
            return f"`orientation` of '{body}' is {_kind(turn)}, but {QUATERNION}"
        if not isfinite(sum(place) + sum(turn) + sum(velocity) + sum(spin)):
            parts = f"position_W {_numbers(place)}, orientation {_numbers(turn)}, velocity_W {_numbers(velocity)}"
            where = f"the state of '{body}' has a number that is not finite"
            return f"{where}: {parts}, angular_velocity_W {_numbers(spin)}"
        if abs(_dot4(turn, turn) - 1.0) > UNIT:
            return f"`orientation` of '{body}' is {_numbers(turn)}, but {QUATERNION}"
    return ""


def _dot4(one: Sequence[float], other: Sequence[float]) -> float:
    """Return the scalar product of two quaternions."""
    return sum(a * b for a, b in zip(one, other, strict=True))


def _is_tuple(value: object, length: int) -> bool:
    """Return whether a value is a tuple of this many numbers; arrays do not compare as tuples do."""
    return isinstance(value, tuple) and len(value) == length and all(isinstance(part, Real) for part in value)


QUATERNION: Final = "must be a tuple (x, y, z, w) of length 1"


def _placing_mistake(got: Pose, brick: Brick, given: Pose) -> str:
    """Return how the pose of a new brick differs from the given one."""
    rounding = SINGLE * max(map(abs, given.position_W))
    if dist(got.position_W, given.position_W) > PLACED * brick.shape.least_thickness + rounding:
        name, value, wanted, order = "position_W", _numbers(got.position_W), _numbers(given.position_W), ""
    elif 1.0 - abs(_dot4(got.orientation, given.orientation)) > UNIT:
        name, value, wanted = "orientation", _numbers(got.orientation), _numbers(given.orientation)
        order = ", in the order x, y, z, w"
    else:
        return ""
    return f"`{name}` of '{brick.id}' is {value} after `add_brick` with {wanted}{order}"


def _contacts_mistake(
    contacts: object, brick: BodyId, planes: Mapping[BodyId, Plane], masses: Mapping[BodyId, float]
) -> str:
    if not isinstance(contacts, Sequence):
        return f"it returned {_kind(contacts)}, but must return a sequence of ContactPoint"
    for point in contacts:
        if not isinstance(point, ContactPoint):
            return f"it returned {_kind(point)} in a sequence that must hold ContactPoint only"
        if mistake := _point_mistake(point, brick, planes, masses):
            return f"contact of '{brick}': {mistake}"
    return ""


def _point_mistake(
    point: ContactPoint, brick: BodyId, planes: Mapping[BodyId, Plane], masses: Mapping[BodyId, float]
) -> str:
    for body in (point.a, point.b):
        if not isinstance(body, str) or not (body in planes or body in masses):
            return f"`a` and `b` are {point.a!r} and {point.b!r}, but must be names of bodies in this world"
    if point.a == point.b or brick not in (point.a, point.b):
        return f"`a` and `b` are '{point.a}' and '{point.b}', but must be '{brick}' and another body"
    for field, length in LENGTHS.items():
        if mistake := _number_mistake(field, getattr(point, field), length):
            return mistake
    normal = point.normal_BA_W
    if abs(dot(normal, normal) - 1.0) > UNIT:
        return f"`normal_BA_W` is {_numbers(normal)}, but must have length 1"
    for body, outward in ((point.b, 1.0), (point.a, -1.0)):
        if body in planes and outward * dot(normal, planes[body].normal_W) < 0.0:
            return (
                f"`normal_BA_W` is {_numbers(normal)}, but must point from `b`, '{point.b}', towards `a`, '{point.a}'"
            )
    if point.normal_force < -PULL * masses[brick]:
        return f"`normal_force` is {point.normal_force:g} N, but must not be negative"
    return ""


LENGTHS: Final = {  # of the fields of a ContactPoint that are tuples of numbers; 1 of those that are numbers
    "position_W": 3,
    "normal_BA_W": 3,
    "gap": 1,
    "normal_force": 1,
    "friction_W": 3,
    "rounded": 2,
    "slid": 1,
}


def _number_mistake(field: str, value: Any, length: int) -> str:  # noqa: ANN401 -- what an engine returned
    """Return what is wrong with a number, or with a tuple of this many numbers."""
    values = (value,) if length == 1 else value
    if not _is_tuple(values, length):
        wanted = "a number" if length == 1 else f"a tuple of {length} numbers"
        return f"`{field}` is {_kind(value)}, but must be {wanted}"
    return "" if isfinite(sum(values)) else f"`{field}` is {_numbers(values)}, which is not finite"


def _neighbours_mistake(names: object, bodies: Set[BodyId]) -> str:
    if not isinstance(names, Sequence) or isinstance(names, str):
        return f"it returned {_kind(names)}, but must return a sequence of the names of bodies"
    wrong = [name for name in names if not isinstance(name, str) or name not in bodies]
    return f"it returned {wrong[0]!r}, which is no name of a body in this world" if wrong else ""


def _kind(value: object) -> str:
    if value is None:
        return "None"
    name = type(value).__name__
    kind = f"{'an' if name.startswith(('a', 'e', 'i', 'o', 'ndarray')) else 'a'} {name}"
    if not isinstance(value, tuple):
        return kind
    odd = next((part for part in value if not isinstance(part, Real)), None)
    return f"{kind} of {len(value)}" if odd is None else f"{kind} with {_kind(odd)}"


def _numbers(values: Sequence[float]) -> str:
    shown = ", ".join(f"{value:.4g}" for value in values)
    return f"({shown})" if len(values) > 1 else shown
