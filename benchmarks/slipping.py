"""How a plank slips that leans on a wall, and how one slides down a slope: equations of motion, and no engine.

Model: a rigid plank of even density in the upright plane across the wall, which is to its right. The lower edge of its
lower face is on the floor, the upper edge of that face on the wall. Coulomb friction at both, static as strong as
kinetic. Two planks that lean on each other are each a plank on a smooth wall: by symmetry they press level.
Source: Newton and Euler, with both ends kept where they touch. Masses are 1 kg; nothing depends on them.

This judges `stability.dynamics.slipping`, so it was written apart from it and stays so: forces come from a linear
system, time from scipy's integrator, and nothing is imported from `stability`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import acos, cos, inf, sin, sqrt, tan
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

ACCURACY = 1e-12  # of each step, of angles [rad] and rates [rad/s]; all in all 1e-10
LONGEST = 10.0  # [s] nothing here takes longer
SHARP = 1e-12  # [s] so closely a moment is found


@dataclass(frozen=True, slots=True)
class Leaning:
    """A plank that leans on a wall."""

    length: float  # [m]
    thickness: float  # [m]
    angle: float  # to the floor [rad]
    floor_friction: float
    wall_friction: float = 0.0
    gravity: float = 9.81  # [m/s2]

    @property
    def inertia(self) -> float:
        """About the centre [kg m2]."""
        return (self.length**2 + self.thickness**2) / 12.0


@dataclass(frozen=True, slots=True)
class Pressed:
    """What happens at an angle and a rate of turning while both ends slide."""

    turning: float  # how fast the rate changes [rad/s2]
    floor: float  # force up [N]
    wall: float  # force away from the wall [N]


@dataclass(frozen=True, slots=True)
class Slip:
    """A plank on its way down, until it leaves the wall or lies."""

    leaning: Leaning
    ends: float  # [s]
    motion: Any  # of scipy: time -> angle, rate, work of friction

    def angle(self, time: float) -> float:
        """To the floor [rad]."""
        return float(self.motion(time)[0])

    def slid(self, time: float) -> float:
        """How far the foot has got [m]."""
        return self.leaning.length * (cos(self.angle(time)) - cos(self.leaning.angle))

    def speed(self, time: float) -> float:
        """Of the foot [m/s]."""
        angle, rate, _ = self.motion(time)
        return -self.leaning.length * sin(angle) * float(rate)

    def energy(self, time: float) -> float:
        """Kinetic and potential, and what friction has taken [J]."""
        angle, rate, taken = (float(value) for value in self.motion(time))
        along_x, along_z = _centre_goes(self.leaning, angle)
        moving = 0.5 * (along_x**2 + along_z**2 + self.leaning.inertia) * rate**2
        return moving + self.leaning.gravity * centre(self.leaning, angle)[1] + taken

    def time_to(self, way: float) -> float:
        """How long the foot takes to get so far [s]; infinite if the plank leaves the wall before."""
        angle = acos(min(1.0, cos(self.leaning.angle) + way / self.leaning.length))
        if self.angle(self.ends) > angle:
            return inf
        early, late = 0.0, self.ends
        while late - early > SHARP:
            middle = 0.5 * (early + late)
            early, late = (middle, late) if self.angle(middle) > angle else (early, middle)
        return late


def needed_friction(length: float, thickness: float, angle: float) -> float:
    """Of a floor that holds a plank which leans on a smooth wall, or each of two that lean on each other."""
    return (1.0 / tan(angle) - thickness / length) / 2.0


def centre(leaning: Leaning, angle: float) -> tuple[float, float]:
    """Of mass, to the right of the wall's foot and up [m]."""
    half, off = leaning.length / 2.0, leaning.thickness / 2.0
    return -half * cos(angle) - off * sin(angle), half * sin(angle) + off * cos(angle)


def _centre_goes(leaning: Leaning, angle: float) -> tuple[float, float]:
    """The way of the centre to the right and up as the angle grows [m/rad]."""
    half, off = leaning.length / 2.0, leaning.thickness / 2.0
    return half * sin(angle) - off * cos(angle), half * cos(angle) - off * sin(angle)


def pressed(leaning: Leaning, angle: float, rate: float) -> Pressed:
    """Forces while the foot slides away from the wall and the top slides down."""
    x, z = centre(leaning, angle)
    along_x, along_z = _centre_goes(leaning, angle)
    foot_x, foot_z = -leaning.length * cos(angle) - x, -z  # from the centre [m]
    top_x, top_z = -x, leaning.length * sin(angle) - z
    floor, wall = leaning.floor_friction, leaning.wall_friction
    # With N of the floor and W of the wall, to the right, up and about the centre:
    # x'' = floor N - W, z'' = N + wall W - g, inertia a'' = their moments; (x, z)'' = along a'' - (x, z) a'^2.
    equations = (
        (along_x, -floor, 1.0),
        (along_z, -1.0, -wall),
        (leaning.inertia, foot_z * floor - foot_x, -top_x * wall - top_z),
    )
    known = (x * rate**2, z * rate**2 - leaning.gravity, 0.0)
    return Pressed(*(float(value) for value in np.linalg.solve(equations, known)))


def gives_way(leaning: Leaning) -> bool:
    """Whether friction at both ends at once, as strong as it can be, does not hold the plank."""
    return pressed(leaning, leaning.angle, 0.0).turning < 0.0


def slip(leaning: Leaning) -> Slip:
    """The motion from rest of a plank that friction does not hold."""
    if not gives_way(leaning):
        raise ValueError("friction holds this plank")

    def change(_: float, state: Sequence[float]) -> tuple[float, float, float]:
        angle, rate, _taken = state
        now = pressed(leaning, angle, rate)
        foot, top = leaning.length * sin(angle) * -rate, leaning.length * cos(angle) * -rate  # [m/s]
        taken = leaning.floor_friction * now.floor * foot + leaning.wall_friction * now.wall * top
        return rate, now.turning, taken

    def leaves(_: float, state: Sequence[float]) -> float:
        return pressed(leaning, state[0], state[1]).wall

    def lies(_: float, state: Sequence[float]) -> float:
        return state[0]

    for event in (leaves, lies):
        setattr(event, "terminal", True)  # noqa: B010 -- how scipy is told; functions have no such attribute for types
    start = (leaning.angle, 0.0, 0.0)
    found = solve_ivp(
        change,
        (0.0, LONGEST),
        start,
        method="DOP853",
        events=(leaves, lies),
        dense_output=True,
        rtol=ACCURACY,
        atol=ACCURACY,
    )
    return Slip(leaning, float(found.t[-1]), found.sol)


def slides(slope: float, friction: float, time: float, gravity: float = 9.81) -> tuple[float, float]:
    """How far [m] a plank has slid from rest down a slope [rad] that is too steep for it, and how fast it is [m/s]."""
    gains = gravity * (sin(slope) - friction * cos(slope))
    return 0.5 * gains * time**2, gains * time


def time_to_slide(way: float, slope: float, friction: float, gravity: float = 9.81) -> float:
    """How long a plank takes to slide so far [m] from rest down a slope that is too steep for it [s]."""
    return sqrt(2.0 * way / (gravity * (sin(slope) - friction * cos(slope))))
