"""Motion of a rigid body about a fixed axis under its weight."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin, sqrt


def runge_kutta(
    acceleration: Callable[[float, float], float], position: float, speed: float, duration: float
) -> tuple[float, float]:
    """Advance position and speed by a short time [s] under `acceleration(position, speed)`, by the classical method."""
    half = 0.5 * duration
    pull = acceleration(position, speed)
    speed_2 = speed + half * pull
    pull_2 = acceleration(position + half * speed, speed_2)
    speed_3 = speed + half * pull_2
    pull_3 = acceleration(position + half * speed_2, speed_3)
    speed_4 = speed + duration * pull_3
    pull_4 = acceleration(position + duration * speed_3, speed_4)
    sixth = duration / 6.0
    return (
        position + sixth * (speed + 2.0 * (speed_2 + speed_3) + speed_4),
        speed + sixth * (pull + 2.0 * (pull_2 + pull_3) + pull_4),
    )


@dataclass(frozen=True, slots=True)
class Pendulum:
    """Rigid body released at rest at the angle 0. Its weight exerts the torque a cos(angle) + b sin(angle)."""

    inertia: float  # about the axis [kg m2]
    torque: float  # a, of the weight about the axis at the angle 0 [N m]
    torque_across: float  # b, the same after a quarter turn [N m]

    def acceleration_at(self, angle: float) -> float:
        """Return the angular acceleration [rad/s2]."""
        return (self.torque * cos(angle) + self.torque_across * sin(angle)) / self.inertia

    def speed_at(self, angle: float) -> float:
        """Return the angular speed, from the height lost [rad/s]."""
        work = self.torque * sin(angle) + self.torque_across * (1.0 - cos(angle))
        return sqrt(max(0.0, 2.0 * work / self.inertia))

    def after(self, angle: float, speed: float, duration: float) -> tuple[float, float]:
        """Return angle [rad] and angular speed [rad/s] after a short time [s]."""
        return runge_kutta(lambda at, _: self.acceleration_at(at), angle, speed, duration)
