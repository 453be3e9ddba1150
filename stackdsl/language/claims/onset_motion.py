"""Compares the onset of a fall with its proof: proven and simulated displacements of bricks.

A proof gives velocities, and a fall is measured after a finite rotation. A body that rotates about a fixed axis moves
along an arc; the chord deviates from the initial direction by half the rotation, and is shorter than the arc. So the
velocities are integrated until the fastest rotating brick has turned as far as in the simulation, each brick along its
own screw, and the result is compared with the simulation.
"""

from math import acos, cos, pi, sin
from typing import TypeAlias

from stability.geometry.vectors import add, cross, dot, norm, scale, subtract, turn_between
from stability.model import Vec3
from stability.problem import Motion
from stackdsl.trace import Onset

SMALL = 0.05  # share of the largest displacement: the directions of smaller ones are noise
STRAIGHT = 1e-6  # [rad] below this rotation, chord and arc are equal

Pairs: TypeAlias = list[tuple[Vec3, Vec3]]  # proven and simulated displacements [m]


def seen_displacements(onset: Onset) -> Pairs | None:
    """Return proven and simulated displacements of each brick [m]; None if the proven motion has no rotation."""
    motion = Motion({name: onset.motion.velocity[name] for name in onset.poses})
    fastest = max(motion.velocity, key=lambda name: norm(motion.velocity[name][1]))
    rate = norm(motion.velocity[fastest][1])
    if rate == 0.0:
        return None
    lasts = turn_between(*onset.poses[fastest]) / rate
    return [
        (along_screw(*motion.velocity[name], lasts), subtract(after.position_W, before.position_W))
        for name, (before, after) in onset.poses.items()
    ]


def along_screw(velocity_W: Vec3, spin_W: Vec3, lasts: float) -> Vec3:
    """Return the displacement of the centre of a body on a screw motion of fixed axis, after a time [m]."""
    turn = scale(lasts, spin_W)
    angle = norm(turn)
    straight = scale(lasts, velocity_W)
    if angle < STRAIGHT:
        return straight
    across = cross(turn, straight)
    sideways = scale((1.0 - cos(angle)) / angle**2, across)
    return add(straight, add(sideways, scale((angle - sin(angle)) / angle**3, cross(turn, across))))


def widest_angle(pairs: Pairs) -> float:
    """Return the widest angle between proven and simulated displacements, of bricks that move far enough [rad]."""
    far = SMALL * max(norm(proven) for proven, _ in pairs)
    return max(_angle(proven, seen) for proven, seen in pairs if norm(proven) >= far)


def _angle(one: Vec3, other: Vec3) -> float:
    lengths = norm(one) * norm(other)
    return acos(max(-1.0, min(1.0, dot(one, other) / lengths))) if lengths > 0.0 else pi


def largest_difference(pairs: Pairs) -> float:
    """Return the largest difference of proven and simulated distances.

    Each distance is relative to that of the brick with the largest proven distance.
    """
    furthest, seen_of_it = max(pairs, key=lambda pair: norm(pair[0]))
    if norm(seen_of_it) == 0.0:
        return 1.0
    return max(abs(norm(seen) / norm(seen_of_it) - norm(proven) / norm(furthest)) for proven, seen in pairs)
