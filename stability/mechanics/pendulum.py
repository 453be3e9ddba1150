"""A rigid body that turns about a fixed axis under its weight: how fast at an angle, and at which angle in time."""

from dataclasses import dataclass
from math import cos, sin, sqrt


@dataclass(frozen=True, slots=True)
class Pendulum:
    """Let go at rest at the angle 0. Its weight turns it by a cos(angle) + b sin(angle), whatever its shape."""

    inertia: float  # about the axis [kg m2]
    torque: float  # a, of the weight about the axis where it was let go [N m]
    torque_across: float  # b, what it would be a quarter of a turn further [N m]

    def acceleration_at(self, angle: float) -> float:
        """Of the angle [rad/s2]."""
        return (self.torque * cos(angle) + self.torque_across * sin(angle)) / self.inertia

    def speed_at(self, angle: float) -> float:
        """Of the angle, from the height lost [rad/s]."""
        work = self.torque * sin(angle) + self.torque_across * (1.0 - cos(angle))
        return sqrt(max(0.0, 2.0 * work / self.inertia))

    def after(self, angle: float, speed: float, duration: float) -> tuple[float, float]:
        """Angle [rad] and its speed [rad/s] a short time [s] later: one step of the classical Runge-Kutta method."""
        half = 0.5 * duration
        pull = self.acceleration_at(angle)
        speed_2, pull_2 = speed + half * pull, self.acceleration_at(angle + half * speed)
        speed_3, pull_3 = speed + half * pull_2, self.acceleration_at(angle + half * speed_2)
        speed_4, pull_4 = speed + duration * pull_3, self.acceleration_at(angle + duration * speed_3)
        sixth = duration / 6.0
        return (
            angle + sixth * (speed + 2.0 * (speed_2 + speed_3) + speed_4),
            speed + sixth * (pull + 2.0 * (pull_2 + pull_3) + pull_4),
        )
