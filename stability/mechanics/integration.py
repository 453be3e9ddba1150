"""Motion in time, where no closed form says it: one step of the classical Runge-Kutta method."""

from collections.abc import Callable


def runge_kutta(
    acceleration: Callable[[float, float], float], position: float, speed: float, duration: float
) -> tuple[float, float]:
    """Position and speed a short time [s] later, of what is accelerated by `acceleration(position, speed)`."""
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
