"""Velocities and positions after a time step: Gauss-Seidel over the contact points with exact friction cones.

A time step is split into sub-steps of a quarter of a millisecond, each with a few sweeps that start from the impulses
of the last sub-step (Macklin et al., "Small steps in physics simulation", SCA 2019). An open gap may close within a
sub-step and no more. An overlap is removed at a limited speed, which a last sweep takes out of the velocities again, so
that it adds no energy (Catto, "Solver2D", 2024).
"""

from math import cos, pi, sin, sqrt

import numpy as np

from stability.engines.rigid.arrays import (
    ALONG,
    DRAGS,
    DRAGS_ACROSS,
    FRESH,
    FRICTION,
    GAP,
    MASS,
    MASS_ACROSS,
    NORMAL,
    OFFSET,
    PRESSES,
    RUBS,
    RUBS_ACROSS,
    Array,
    Bodies,
    Points,
    compiled,
)

# An overlap acts as a damped spring of a quarter of the frequency of the sub-steps, with ten times critical damping.
PHASE, DAMPING = 0.5 * pi, 10.0
RATE = PHASE / (2.0 * DAMPING + PHASE)  # share of an overlap that a sub-step removes
SOFT = PHASE * (2.0 * DAMPING + PHASE) / (1.0 + PHASE * (2.0 * DAMPING + PHASE))
LEAK = 1.0 - SOFT
STRAIGHT = 1e-4  # [rad] below which sine and cosine are those of their series


@compiled
def advance(
    bodies: Bodies,
    points: Points,
    count: int,
    timing: tuple[float, int, int, int],
    recovery: float,
    gravity_W: Array,
) -> None:
    """Advance all bodies by a time step [s] in sub-steps, with sweeps in each and in the first after new contacts.

    The points keep the impulses of the last sub-step. `recovery` is the speed at which overlaps are removed [m/s].
    """
    duration, parts, sweeps, first_sweeps = timing
    h, moving, row = duration / parts, len(bodies.inverse_mass) - 1, points.row
    pressed = np.zeros(moving + 1, np.int64)
    fresh = False
    for c in range(count):
        fresh = fresh or row[c, FRESH] > 0.0
    for part in range(parts):
        for i in range(moving):
            pressed[i] = 0
            if bodies.inverse_mass[i] > 0.0:
                for k in range(3):
                    bodies.motion[i, k] += h * (gravity_W[k] + bodies.inverse_mass[i] * bodies.force[i, k])
                _spin_on(bodies, i, h)
                if bodies.guide[i, 0] > 0.0:
                    _follow_guide(bodies, i)
        if count > 0:
            _prepare(bodies, points, count)
            for c in range(count):
                if row[c, PRESSES] > 0.0:
                    first, second = points.bodies[c, 0], points.bodies[c, 1]
                    pressing, along, across = row[c, PRESSES], row[c, RUBS], row[c, RUBS_ACROSS]
                    _push(bodies.motion, bodies.inverse_mass, first, second, row, c, pressing, along, across)
            for k in range(first_sweeps if fresh and part == 0 else sweeps):
                _sweep(bodies, points, count, h, recovery, (k + part) % 2 == 1)
            for c in range(count):
                if row[c, PRESSES] > 0.0:
                    pressed[points.bodies[c, 0]] = pressed[points.bodies[c, 1]] = 1
        for i in range(moving):
            if bodies.guide[i, 0] > 0.0:
                _follow_guide(bodies, i)
            # The path of a free fall is exact; a body that touches others follows its new velocity.
            bent = 0.0 if pressed[i] == 1 or bodies.inverse_mass[i] == 0.0 else -0.5 * h * h
            for k in range(3):
                bodies.position[i, k] += h * bodies.motion[i, k] + bent * gravity_W[k]
            _turn(bodies.turn[i], bodies.motion[i, 3:], h)
            place_axes(bodies, i)
        if count > 0:
            _sweep(bodies, points, count, h, 0.0, part % 2 == 0)


@compiled
def place_axes(bodies: Bodies, i: int) -> None:
    """Compute the rotation matrix of a body and its response to torques from its quaternion."""
    x, y, z, w = bodies.turn[i, 0], bodies.turn[i, 1], bodies.turn[i, 2], bodies.turn[i, 3]
    r, a = bodies.axes[i], bodies.response[i]
    r[0], r[1], r[2] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)
    r[3], r[4], r[5] = 2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)
    r[6], r[7], r[8] = 2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)
    p, q, s = bodies.inverse_moments[i, 0], bodies.inverse_moments[i, 1], bodies.inverse_moments[i, 2]
    a[0] = r[0] * r[0] * p + r[1] * r[1] * q + r[2] * r[2] * s
    a[1] = r[0] * r[3] * p + r[1] * r[4] * q + r[2] * r[5] * s
    a[2] = r[0] * r[6] * p + r[1] * r[7] * q + r[2] * r[8] * s
    a[3] = r[3] * r[3] * p + r[4] * r[4] * q + r[5] * r[5] * s
    a[4] = r[3] * r[6] * p + r[4] * r[7] * q + r[5] * r[8] * s
    a[5] = r[6] * r[6] * p + r[7] * r[7] * q + r[8] * r[8] * s


@compiled
def _follow_guide(bodies: Bodies, i: int) -> None:
    """Give a slid body its prescribed velocity, except along its free axis, and no spin about this axis."""
    m, g = bodies.motion, bodies.guide
    x, y, z = g[i, 4], g[i, 5], g[i, 6]
    along = (m[i, 0] - g[i, 1]) * x + (m[i, 1] - g[i, 2]) * y + (m[i, 2] - g[i, 3]) * z
    about = m[i, 3] * x + m[i, 4] * y + m[i, 5] * z
    for k in range(3):
        m[i, k] = g[i, 1 + k] + along * g[i, 4 + k]
        m[i, 3 + k] -= about * g[i, 4 + k]


@compiled
def _spin_on(bodies: Bodies, i: int, h: float) -> None:
    """Change a spin by the torque from outside, and by Euler's equations with the implicit midpoint rule."""
    r, w, a, t = bodies.axes[i], bodies.motion[i, 3:], bodies.response[i], bodies.torque[i]
    x = w[0] + h * (a[0] * t[0] + a[1] * t[1] + a[2] * t[2])
    y = w[1] + h * (a[1] * t[0] + a[3] * t[1] + a[4] * t[2])
    z = w[2] + h * (a[2] * t[0] + a[4] * t[1] + a[5] * t[2])
    m, n, o = 1.0 / bodies.inverse_moments[i, 0], 1.0 / bodies.inverse_moments[i, 1], 1.0 / bodies.inverse_moments[i, 2]
    u0, v0, w0 = r[0] * x + r[3] * y + r[6] * z, r[1] * x + r[4] * y + r[7] * z, r[2] * x + r[5] * y + r[8] * z
    u, v, s = u0, v0, w0
    for _ in range(3):
        um, vm, sm = 0.5 * (u + u0), 0.5 * (v + v0), 0.5 * (s + w0)
        u = u0 + h * (n - o) / m * vm * sm
        v = v0 + h * (o - m) / n * sm * um
        s = w0 + h * (m - n) / o * um * vm
    w[0], w[1], w[2] = r[0] * u + r[1] * v + r[2] * s, r[3] * u + r[4] * v + r[5] * s, r[6] * u + r[7] * v + r[8] * s


@compiled
def _turn(q: Array, spin: Array, h: float) -> None:
    """Rotate a quaternion by a spin for a time [s]."""
    a, b, c = 0.5 * h * spin[0], 0.5 * h * spin[1], 0.5 * h * spin[2]
    angle = sqrt(a * a + b * b + c * c)
    if angle < STRAIGHT:
        sine, cosine = 1.0 - angle * angle / 6.0, 1.0 - angle * angle / 2.0
    else:
        sine, cosine = sin(angle) / angle, cos(angle)
    a, b, c = sine * a, sine * b, sine * c
    x, y, z, w = q[0], q[1], q[2], q[3]
    q[0] = cosine * x + a * w + b * z - c * y
    q[1] = cosine * y + b * w + c * x - a * z
    q[2] = cosine * z + c * w + a * y - b * x
    q[3] = cosine * w - a * x - b * y - c * z
    length = 1.0 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for k in range(4):
        q[k] *= length


@compiled
def _prepare(bodies: Bodies, points: Points, count: int) -> None:
    """Compute arms, gaps, effective masses and responses of all points at the current poses."""
    row, axes, position, k = points.row, bodies.axes, bodies.position, bodies.response
    for c in range(count):
        gap = row[c, OFFSET]
        normal = along = across = drags = drags_across = 0.0
        for side in range(2):
            i, on, arm, turns = points.bodies[c, side], 9 + 3 * side, 22 + 3 * side, 32 + 9 * side
            sign = 2.0 * side - 1.0
            u, v, w = row[c, on], row[c, on + 1], row[c, on + 2]
            x = axes[i, 0] * u + axes[i, 1] * v + axes[i, 2] * w
            y = axes[i, 3] * u + axes[i, 4] * v + axes[i, 5] * w
            z = axes[i, 6] * u + axes[i, 7] * v + axes[i, 8] * w
            row[c, arm], row[c, arm + 1], row[c, arm + 2] = x, y, z
            a, b, d = row[c, 0], row[c, 1], row[c, 2]
            gap += sign * (a * (x + position[i, 0]) + b * (y + position[i, 1]) + d * (z + position[i, 2]))
            m = bodies.inverse_mass[i]
            if m == 0.0:
                for column in range(turns, turns + 9):
                    row[c, column] = 0.0
                continue
            for axis in range(0, 9, 3):
                a, b, d, to = row[c, axis], row[c, axis + 1], row[c, axis + 2], turns + axis
                t, u, v = y * d - z * b, z * a - x * d, x * b - y * a
                p = k[i, 0] * t + k[i, 1] * u + k[i, 2] * v
                q = k[i, 1] * t + k[i, 3] * u + k[i, 4] * v
                r = k[i, 2] * t + k[i, 4] * u + k[i, 5] * v
                row[c, to], row[c, to + 1], row[c, to + 2] = p, q, r
                along_axis = m + t * p + u * q + v * r
                coupled = t * row[c, turns] + u * row[c, turns + 1] + v * row[c, turns + 2]
                if axis == NORMAL:
                    normal += along_axis
                elif axis == ALONG:
                    along, drags = along + along_axis, drags + coupled
                else:
                    across, drags_across = across + along_axis, drags_across + coupled
        row[c, GAP], row[c, MASS], row[c, MASS_ACROSS] = gap, 1.0 / normal, 1.0 / max(along, across)
        row[c, DRAGS], row[c, DRAGS_ACROSS] = drags, drags_across


@compiled
def _push(
    motion: Array,
    inverse_mass: Array,
    first: int,
    second: int,
    row: Array,
    c: int,
    pressing: float,
    along: float,
    across: float,
) -> None:
    """Apply an impulse at a point to the second body, and its opposite to the first."""
    p = (pressing * row[c, 0] + along * row[c, 3]) + across * row[c, 6]
    q = (pressing * row[c, 1] + along * row[c, 4]) + across * row[c, 7]
    r = (pressing * row[c, 2] + along * row[c, 5]) + across * row[c, 8]
    m = inverse_mass[first]
    motion[first, 0] -= m * p
    motion[first, 1] -= m * q
    motion[first, 2] -= m * r
    motion[first, 3] -= (pressing * row[c, 32] + along * row[c, 35]) + across * row[c, 38]
    motion[first, 4] -= (pressing * row[c, 33] + along * row[c, 36]) + across * row[c, 39]
    motion[first, 5] -= (pressing * row[c, 34] + along * row[c, 37]) + across * row[c, 40]
    m = inverse_mass[second]
    motion[second, 0] += m * p
    motion[second, 1] += m * q
    motion[second, 2] += m * r
    motion[second, 3] += (pressing * row[c, 41] + along * row[c, 44]) + across * row[c, 47]
    motion[second, 4] += (pressing * row[c, 42] + along * row[c, 45]) + across * row[c, 48]
    motion[second, 5] += (pressing * row[c, 43] + along * row[c, 46]) + across * row[c, 49]


@compiled
def _sweep(bodies: Bodies, points: Points, count: int, h: float, recovery: float, backwards: bool) -> None:
    """Solve Signorini's and Coulomb's laws at one point after the other."""
    row, w, inverse_mass = points.row, bodies.motion, bodies.inverse_mass
    rate = 1.0 / h
    for k in range(count):
        c = count - 1 - k if backwards else k
        i, j = points.bodies[c, 0], points.bodies[c, 1]
        x, y, z, a, b, d = row[c, 25], row[c, 26], row[c, 27], row[c, 22], row[c, 23], row[c, 24]
        p = (w[j, 0] - w[i, 0]) + ((w[j, 4] * z - w[j, 5] * y) - (w[i, 4] * d - w[i, 5] * b))
        q = (w[j, 1] - w[i, 1]) + ((w[j, 5] * x - w[j, 3] * z) - (w[i, 5] * a - w[i, 3] * d))
        r = (w[j, 2] - w[i, 2]) + ((w[j, 3] * y - w[j, 4] * x) - (w[i, 3] * b - w[i, 4] * a))
        before, gap = row[c, PRESSES], row[c, GAP]
        opening = (p * row[c, 0] + q * row[c, 1]) + r * row[c, 2]
        if gap > 0.0:
            pressing = before - row[c, MASS] * (opening + gap * rate)
        elif recovery > 0.0:
            pressing = (1.0 - LEAK) * before - SOFT * row[c, MASS] * (opening + max(RATE * gap * rate, -recovery))
        else:
            pressing = before - row[c, MASS] * opening
        if pressing <= 0.0:
            if before == 0.0:
                continue
            pressing = 0.0
        more, rubs, rubs_across = pressing - before, row[c, RUBS], row[c, RUBS_ACROSS]
        along = rubs - row[c, MASS_ACROSS] * ((p * row[c, 3] + q * row[c, 4]) + (r * row[c, 5] + more * row[c, DRAGS]))
        across = rubs_across - row[c, MASS_ACROSS] * (
            (p * row[c, 6] + q * row[c, 7]) + (r * row[c, 8] + more * row[c, DRAGS_ACROSS])
        )
        size, most = along * along + across * across, row[c, FRICTION] * pressing
        if size > most * most:
            share = most / sqrt(size)
            along, across = share * along, share * across
        row[c, PRESSES], row[c, RUBS], row[c, RUBS_ACROSS] = pressing, along, across
        _push(w, inverse_mass, i, j, row, c, more, along - rubs, across - rubs_across)
