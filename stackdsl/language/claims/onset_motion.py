"""How a fall begins: how far bricks were proven to go, and how far they were seen to.

A proof names velocities, and a fall is seen after a finite turn. A body that turns about a fixed axis moves along an
arc; its chord lies half the turn away from where it set out to, and is shorter than the arc. So the velocities are
followed as far as the brick that turns fastest was seen to turn, each brick along its own screw, and what comes of that
is compared with what was seen.
"""

from math import acos, cos, pi, sin
from typing import TypeAlias

from stability.geometry.vectors import add, cross, dot, norm, scale, subtract, turn_between
from stability.model import Vec3
from stability.problem import Motion
from stackdsl.trace import Onset

SMALL = 0.05  # share of the largest displacement: the directions of smaller ones are noise
STRAIGHT = 1e-6  # [rad] a turn whose chord is its arc

Pairs: TypeAlias = list[tuple[Vec3, Vec3]]  # a proven displacement, and the one seen [m]


def seen_displacements(onset: Onset) -> Pairs | None:
    """How far each brick gets by so much of the proven motion, and how far it was seen to [m]; None without a turn."""
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
    """How far the centre of a body gets that turns about and moves along a fixed axis, from its velocities now."""
    turn = scale(lasts, spin_W)
    angle = norm(turn)
    straight = scale(lasts, velocity_W)
    if angle < STRAIGHT:
        return straight
    across = cross(turn, straight)
    sideways = scale((1.0 - cos(angle)) / angle**2, across)
    return add(straight, add(sideways, scale((angle - sin(angle)) / angle**3, cross(turn, across))))


def widest_angle(pairs: Pairs) -> float:
    """Between proven and seen displacements, of the bricks that go far enough to have a direction [rad]."""
    far = SMALL * max(norm(proven) for proven, _ in pairs)
    return max(_angle(proven, seen) for proven, seen in pairs if norm(proven) >= far)


def _angle(one: Vec3, other: Vec3) -> float:
    lengths = norm(one) * norm(other)
    return acos(max(-1.0, min(1.0, dot(one, other) / lengths))) if lengths > 0.0 else pi


def largest_difference(pairs: Pairs) -> float:
    """Between how far bricks were proven and seen to go, both as shares of the brick that was proven to go furthest."""
    furthest, seen_of_it = max(pairs, key=lambda pair: norm(pair[0]))
    if norm(seen_of_it) == 0.0:
        return 1.0
    return max(abs(norm(seen) / norm(seen_of_it) - norm(proven) / norm(furthest)) for proven, seen in pairs)
