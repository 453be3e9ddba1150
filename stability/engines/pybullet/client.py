"""The bodies of a client that somebody else runs, through the protocol of `stability.engines.protocol`."""

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field

from stability.engines.pybullet.client_bodies import ClientBodies
from stability.engines.pybullet.client_shapes import in_words, shape_of, warn_of_unknown
from stability.engines.pybullet.pybullet_binding import pybullet
from stability.model import BodyId, BodyState, ContactPoint, Pose, Shape, Vec3

NOT_LOOKED = (-1, -1)  # in the place of the count and the last number of the bodies


@dataclass
class PyBulletBodies:
    """The bodies of a running client: single bodies with mass are bricks, those without (at first sight) are fixed.

    Bodies with joints are neither, and with `only` nor is any body whose number is not in it. Bodies are called by name
    if they are in `names`, else by their number as text. New ones are noticed by themselves. The first body of each
    shape that is not known here is told by an UnknownShapeWarning.
    """

    client: int
    only: Set[int] | None = None
    names: dict[int, BodyId] = field(default_factory=dict)
    _bodies: ClientBodies = field(init=False)
    _clock: float = field(default=0.0, init=False)
    _masses: dict[BodyId, float] = field(default_factory=dict, init=False)
    _fixed: frozenset[BodyId] = field(default=frozenset(), init=False)
    _shapes: dict[BodyId, Shape] = field(default_factory=dict, init=False)
    _noticed: tuple[int, int] = field(default=NOT_LOOKED, init=False)
    _gravity_W: Vec3 | None = field(default=None, init=False)  # as it was when somebody asked
    _warned_of: set[tuple[bool, str]] = field(default_factory=set, init=False)  # fixed or not, and what shape

    def __post_init__(self) -> None:
        if not isinstance(self.client, int):
            raise TypeError(f"expected the number of a client, as p.connect gives it, not {self.client!r}")
        if not pybullet.getConnectionInfo(self.client)["isConnected"]:
            raise ValueError(f"there is no client {self.client}: p.connect gives the number of one")
        self._bodies = ClientBodies(self.client, self.names)

    def time(self) -> float:
        return self._clock

    def step(self) -> None:
        """Step the client once."""
        pybullet.stepSimulation(self.client)
        self.stepped()

    def stepped(self) -> None:
        """Say that the owner has stepped the client once. Raises ValueError if its gravity is no longer as it was."""
        parameters = pybullet.getPhysicsEngineParameters(self.client)
        self._clock += float(parameters["fixedTimeStep"])
        if self._gravity_W is not None and _gravity(parameters) != self._gravity_W:
            now = f"{self._gravity_W} to {_gravity(parameters)} m/s2"
            raise ValueError(f"the gravity of the client has changed from {now}: make the extension anew")

    def gravity_W(self) -> Vec3:
        """The gravity of the client; from now on it must stay."""
        self._gravity_W = _gravity(pybullet.getPhysicsEngineParameters(self.client))
        return self._gravity_W

    def masses(self) -> Mapping[BodyId, float]:
        self._notice_bodies()
        return self._masses

    def fixed(self) -> Set[BodyId]:
        self._notice_bodies()
        return self._fixed

    def _notice_bodies(self) -> None:
        # Count and last number tell of almost all changes; `holds` finds a body that took over a number.
        count = pybullet.getNumBodies(self.client)
        last = pybullet.getBodyUniqueId(count - 1, self.client) if count else -1
        if (count, last) == self._noticed:
            return
        self._noticed = (count, last)
        before = self._bodies.numbers
        numbers = [pybullet.getBodyUniqueId(index, self.client) for index in range(count)]
        self._bodies.numbers = {self._bodies.name_of(number): number for number in numbers}
        self._sort_out({name: self._mass(name, before) for name in self._bodies.numbers})

    def _mass(self, name: BodyId, before: Mapping[BodyId, int]) -> float:
        """The mass of a body [kg]; of a brick that is frozen by now, what it was at first sight."""
        if before.get(name) == self._bodies.numbers[name] and (name in self._masses or name in self._fixed):
            return self._masses.get(name, 0.0)
        return self._bodies.mass(name)

    def _sort_out(self, masses: Mapping[BodyId, float]) -> None:
        """Tell bricks from what is fixed, by the masses of all bodies [kg]."""
        numbers = self._bodies.numbers
        single = {name for name, number in numbers.items() if pybullet.getNumJoints(number, self.client) == 0}
        self._masses = {
            name: mass
            for name, mass in masses.items()
            if mass > 0.0 and name in single and (self.only is None or numbers[name] in self.only)
        }
        self._fixed = frozenset(name for name, mass in masses.items() if mass == 0.0 and name in single)
        self._shapes = {name: shape for name, shape in self._shapes.items() if name in numbers}

    def shape(self, body: BodyId) -> Shape:
        if body not in self._shapes:
            parts = pybullet.getCollisionShapeData(self._bodies.numbers[body], -1, self.client)
            self._shapes[body] = shape_of(parts, body in self._fixed)
            if self._shapes[body] is None:
                self._warn(body, parts)
        return self._shapes[body]

    def _warn(self, body: BodyId, parts: Sequence[Sequence[object]]) -> None:
        fixed = body in self._fixed
        what = in_words(parts)
        if (fixed, what) not in self._warned_of:
            self._warned_of.add((fixed, what))
            warn_of_unknown(body, what, fixed)

    def near(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return sorted(self._bodies.near(brick, within))

    def states(self, bodies: Collection[BodyId]) -> dict[BodyId, BodyState]:
        return self._bodies.states(bodies)

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        return self._bodies.contacts(brick)

    def freeze(self, brick: BodyId) -> None:
        self._notice_bodies()  # while the mass of a new brick can still be seen
        self._bodies.hold(brick)

    def holds(self, brick: BodyId) -> bool:
        mass = self._bodies.mass(brick)
        if mass == 0.0:
            return True
        # The owner has given it a mass, or has put another body in its place, under the same number.
        self._masses = {**self._masses, brick: mass}
        self._shapes.pop(brick, None)
        return False

    def wake(self, brick: BodyId) -> None:
        self._bodies.let_go(brick, self._masses[brick])

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self._bodies.put(brick, pose)


def _gravity(parameters: Mapping[str, float]) -> Vec3:
    x, y, z = (float(parameters[f"gravityAcceleration{axis}"]) for axis in "XYZ")
    return x, y, z
