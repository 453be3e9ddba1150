"""Steps a client as finely as what is awake asks for, and knows the time."""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import sqrt

from stability.engines.pressing import Presses
from stability.engines.pybullet.free_fall import FreeFall
from stability.engines.pybullet.parameters import step_parameters
from stability.engines.pybullet.pybullet_binding import pybullet
from stability.engines.pybullet.pybullet_settings import PyBulletSettings
from stability.engines.pybullet.sliding_friction import SlidingFriction, presses_sideways
from stability.engines.pybullet.stepping import Awake, Stepping, stepping


@dataclass
class Stepper:
    """The clock of a world, and how its next step is taken."""

    client: int
    settings: PyBulletSettings
    fall: FreeFall
    presses: Presses = field(default_factory=Presses, init=False)
    sliding: SlidingFriction = field(init=False)
    time: float = field(default=0.0, init=False)  # [s]
    _fastest: float = field(default=0.0, init=False)  # [m/s]
    _eased: int = field(default=0, init=False)  # steps to come in which bodies begin to press, or push on
    _suited: bool = field(default=False, init=False)  # False: something else is awake, look again
    _stepping: Stepping = field(init=False)  # what the engine knows

    def __post_init__(self) -> None:
        self._stepping = stepping(self.settings, Awake())
        self.sliding = SlidingFriction(self.client)

    @property
    def lively(self) -> bool:
        """Whether something may hit something, as far as the engine knows."""
        return self._stepping.lively

    @property
    def part(self) -> float:
        """How long a step of the engine is [s], as far as it knows."""
        return self.settings.time_step / self._stepping.parts

    def limit_travel(self, fastest: float) -> None:
        """Say how fast the bodies of the coming steps are at most [m/s]; steps are taken to suit that."""
        self._fastest, self._suited = fastest, False

    def ease_in(self) -> None:
        """Say that bodies which did not press on each other begin to: split the first steps, as the settings say.

        What is hit is woken some ten of them before, and may be pushed for twice as many: then as many follow.
        """
        self._eased, self._suited = 2 * self.settings.first_steps, False

    def look_again(self) -> None:
        """Note that something else is awake than before."""
        self._suited = False

    def suit(self, mass_ratio: Callable[[], float]) -> bool:
        """Let the engine step as suits what is awake; returns whether `lively` has changed.

        `mass_ratio` says how many times the mass of the lightest body that is awake the heaviest has.
        """
        if self._suited:
            return False
        before = self._stepping
        ratio = 1.0 if self.settings.most_mass_ratio is None else mass_ratio()
        self._stepping = stepping(self.settings, Awake(self._fastest, ratio, self._eased > 0))
        self._suited = True
        if self._stepping != before:
            parameters = step_parameters(self.settings, self._stepping)
            pybullet.setPhysicsEngineParameter(**parameters, physicsClientId=self.client)
        return self._stepping.lively != before.lively

    def step(self) -> None:
        """Let one time step pass, in the parts that it was suited to."""
        parts = self._stepping.parts
        duration = self.settings.time_step / parts
        self.sliding.begin()
        for part in range(parts):
            self._exert(duration)
            if part == 0:
                self.fall.step(duration)
            else:
                self.fall.go_on(duration)
            if self.settings.sliding_cones and self.lively:
                self.sliding.turn(duration * sqrt(self.settings.scale))
        if self._eased:
            self._eased -= 1
            if self._eased == self.settings.first_steps and not self._pushes_on():
                self._eased = 0
            self._suited = self._suited and self._eased > 0
        self.time += self.settings.time_step

    def _pushes_on(self) -> bool:
        """True while a thrown or falling body still pushes the body that it hit."""
        return self._stepping.may_hit and presses_sideways(self.client)

    def _exert(self, duration: float) -> None:
        """Let what presses on bodies act in the coming engine step of a duration [s].

        As a change of motion: PyBullet leaves the torque of forces out when it works out what friction must stop, and a
        brick that is pressed on one side slides away.
        """
        for acting in self.presses.acting(self.fall.bodies, duration):
            after = acting.pushed()
            self.fall.bodies.set_motion(acting.brick.id, after.velocity_W, after.angular_velocity_W)
