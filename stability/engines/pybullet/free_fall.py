"""Bodies that are let go, so that the way that they fall is exact.

PyBullet moves a body on by the speed that it will have. So speeds belong to the middle of a step, and gravity acts from
there to the middle of the next: for half a step on what was let go, and for the mean of two steps where they change.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import sqrt

from stability.engines.pybullet.client_bodies import ClientBodies
from stability.engines.pybullet.pybullet_binding import pybullet
from stability.geometry.vectors import add
from stability.model import AT_REST, BodyId, BodyState, Vec3


@dataclass
class FreeFall:
    """Which bodies have just been let go, and which fly."""

    bodies: ClientBodies
    gravity: float  # [m/s2] along -z
    exact: bool
    flying: set[BodyId] = field(default_factory=set, init=False)  # let go, and not seen to touch anything since
    _let_go: set[BodyId] = field(default_factory=set, init=False)  # since the last step
    acceleration_W: Vec3 = field(default=AT_REST, init=False)  # of the ground [m/s2]
    _pulls: Vec3 = field(init=False)  # as the engine was told last [m/s2]
    _last_step: float = field(default=0.0, init=False)  # how long the last engine step was [s]
    # What is done before each engine step: it is told how all is pulled in it [m/s2], and how long it is [s].
    before: Callable[[Vec3, float], None] = field(default=lambda _pull_W, _duration: None, init=False)

    def __post_init__(self) -> None:
        self._pulls = (0.0, 0.0, -self.gravity)

    def begin(self, body: BodyId) -> None:
        """Note that a body is awake from now on."""
        if self.exact:
            self._let_go.add(body)

    def end(self, body: BodyId) -> None:
        """Note that a body does not fall any more, or does so already."""
        self._let_go.discard(body)
        self.flying.discard(body)

    def step(self, duration: float) -> None:
        """Take an engine step of a duration [s], the first after what was let go since the last."""
        last, self._last_step = self._last_step or duration, duration
        if self._let_go:
            self._lift(0.5 * self.gravity * last)
        if last == duration or not self.exact:
            self._pull(self.gravity)
            self.go_on(duration)
            return
        self._pull(0.5 * self.gravity * (last + duration) / duration)
        self.go_on(duration)
        self._pull(self.gravity)

    def go_on(self, duration: float) -> None:
        """Take another engine step [s], after one of the same duration."""
        self.before(self._pulls, duration)
        pybullet.stepSimulation(self.bodies.client)

    def _pull(self, gravity: float) -> None:
        """Let the engine pull with so much gravity, and with what bodies feel of the ground [m/s2]."""
        x, y, z = self.acceleration_W
        pull = (-x, -y, -gravity - z)
        # What is let go remembers how it was pulled when it was held.
        if pull != self._pulls or self.acceleration_W != AT_REST:
            pybullet.setGravity(*pull, self.bodies.client)
            self._pulls = pull

    def _lift(self, speed: float) -> None:
        """Throw what was let go upwards [m/s]."""
        for name in sorted(self._let_go, key=self.bodies.numbers.__getitem__):
            (vx, vy, vz), angular_velocity = self.bodies.raw_motion(name)
            lifted = (vx, vy, vz + speed * sqrt(self.bodies.scale))
            self.bodies.set_raw_motion(name, lifted, angular_velocity)
        self.flying |= self._let_go
        self._let_go.clear()

    def corrected(self, states: Mapping[BodyId, BodyState]) -> dict[BodyId, BodyState]:
        """States as of now: the engine's speed of what flies is that of the middle of the last step."""
        found = dict(states)
        for name in self.flying & found.keys():
            if self.bodies.raw_contacts(name):
                self.flying.discard(name)
            else:
                since = (0.0, 0.0, -0.5 * self.gravity * self._last_step)
                found[name] = replace(found[name], velocity_W=add(found[name].velocity_W, since))
        return found
