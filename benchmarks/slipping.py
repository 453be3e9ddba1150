"""Equations of motion of a plank that slips on a wall, and of one that slides down a slope, without an engine.

Model: a rigid plank of uniform density in the vertical plane across the wall, which is to its right. The lower edge of
its lower face is on the floor, the upper edge of that face on the wall. Coulomb friction acts at both, with equal
static and kinetic coefficients. Each of two planks that lean on each other is a plank on a smooth wall: by symmetry
their contact force is horizontal. Source: Newton and Euler, with both ends in contact. Masses are 1 kg; nothing depends
on them.

This verifies slips on `stability.engines.rigid`, so it is independent of it: forces come from a linear system, time
from scipy's integrator, and nothing is imported from `stability`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import acos, cos, inf, sin, sqrt, tan
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

ACCURACY = 1e-12  # of each step, of angles [rad] and rates [rad/s]; the total error is about 1e-10
LONGEST = 10.0  # [s] longer than any motion here
SHARP = 1e-12  # [s] accuracy of times


@dataclass(frozen=True, slots=True)
class Leaning:
    """Plank that leans on a wall."""

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
    """Forces at an angle and a rate while both ends slide."""

    turning: float  # angular acceleration [rad/s2]
    floor: float  # upward force of the floor [N]
    wall: float  # force of the wall, away from it [N]


@dataclass(frozen=True, slots=True)
class Slip:
    """Motion of a plank until it leaves the wall or lies flat."""

    leaning: Leaning
    ends: float  # [s]
    motion: Any  # of scipy: time -> angle, rate, work of friction

    def angle(self, time: float) -> float:
        """Return the angle to the floor [rad]."""
        return float(self.motion(time)[0])

    def slid(self, time: float) -> float:
        """Return the displacement of the foot [m]."""
        return self.leaning.length * (cos(self.angle(time)) - cos(self.leaning.angle))

    def speed(self, time: float) -> float:
        """Return the speed of the foot [m/s]."""
        angle, rate, _ = self.motion(time)
        return -self.leaning.length * sin(angle) * float(rate)

    def energy(self, time: float) -> float:
        """Return kinetic and potential energy plus the work of friction [J]."""
        angle, rate, taken = (float(value) for value in self.motion(time))
        along_x, along_z = _centre_goes(self.leaning, angle)
        moving = 0.5 * (along_x**2 + along_z**2 + self.leaning.inertia) * rate**2
        return moving + self.leaning.gravity * centre(self.leaning, angle)[1] + taken

    def time_to(self, way: float) -> float:
        """Return the time of a displacement of the foot [s]; infinite if the plank leaves the wall before."""
        angle = acos(min(1.0, cos(self.leaning.angle) + way / self.leaning.length))
        if self.angle(self.ends) > angle:
            return inf
        early, late = 0.0, self.ends
        while late - early > SHARP:
            middle = 0.5 * (early + late)
            early, late = (middle, late) if self.angle(middle) > angle else (early, middle)
        return late


def needed_friction(length: float, thickness: float, angle: float) -> float:
    """Return the least friction of a floor for a plank on a smooth wall, or for each of two that lean on each other."""
    return (1.0 / tan(angle) - thickness / length) / 2.0


def centre(leaning: Leaning, angle: float) -> tuple[float, float]:
    """Return the centre of mass, to the right of the wall's foot and up [m]."""
    half, off = leaning.length / 2.0, leaning.thickness / 2.0
    return -half * cos(angle) - off * sin(angle), half * sin(angle) + off * cos(angle)


def _centre_goes(leaning: Leaning, angle: float) -> tuple[float, float]:
    """Return the displacement of the centre to the right and up per change of the angle [m/rad]."""
    half, off = leaning.length / 2.0, leaning.thickness / 2.0
    return half * sin(angle) - off * cos(angle), half * cos(angle) - off * sin(angle)


def pressed(leaning: Leaning, angle: float, rate: float) -> Pressed:
    """Return the forces while the foot slides away from the wall and the top slides down."""
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
    """Return whether friction at its limit at both ends does not hold the plank."""
    return pressed(leaning, leaning.angle, 0.0).turning < 0.0


def slip(leaning: Leaning) -> Slip:
    """Return the motion from rest of a plank that friction does not hold."""
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
        setattr(event, "terminal", True)  # noqa: B010 -- scipy's interface; functions have no such attribute for types
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
    """Return the displacement [m] and speed [m/s] of a plank that slides from rest down a steep slope [rad]."""
    gains = gravity * (sin(slope) - friction * cos(slope))
    return 0.5 * gains * time**2, gains * time


def time_to_slide(way: float, slope: float, friction: float, gravity: float = 9.81) -> float:
    """Return the time in which a plank slides a distance [m] from rest down a steep slope [s]."""
    return sqrt(2.0 * way / (gravity * (sin(slope) - friction * cos(slope))))
