"""A proof that rest is all that can happen in a branch: the power of forces on a virtual motion, checked by arithmetic.

Let bricks at rest start with accelerations a under loads g and contact forces f, so that M a = g + J' f. Take T a as a
virtual motion, with any matrix T, and compare powers:

    a' T' M a  =  g . T a  +  sum over points of f . J T a.

Known of every start are products of a with loads and forces that cannot be positive, whichever way it goes:

- of whatever part l . a is not negative (points do not open inwards, the loads gain, the sides of the branch), -(l . a)
  and -(l . a) (k . f) for every k in the dual of the friction cone; for a point's own normal part any k, of any sign,
  since a force acts only where nothing opens;
- for every contact, friction brakes at least as if it pointed along one direction: the sum of f_t . a_t + f_n (w . a_t)
  for any w not longer than the friction coefficient. With w constant this holds of pressure anywhere on a patch;
- where edges or corners meet, with several normals, f . a alone.

If the right side is a sum of such products, as a polynomial in a, g and f, then a' T' M a is not positive; and if T' M
less a sum of products (l . a) (m . a) is no less than M / 2 then a' M a <= 0: nothing starts. The multipliers are a
proof because the coefficients agree; what they lack by rounding bounds how fast anything could start.
"""

from dataclasses import dataclass

import numpy as np

from stability.statics.outcomes.branch import Branch, Known, known
from stability.statics.outcomes.start_equations import Array, StartEquations

STILL = 1e-9  # of the largest load over the largest mass, per such a load in contact: starts slower than this are none


@dataclass(frozen=True, slots=True, eq=False)
class Multipliers:
    """How the power of forces on a virtual motion is a sum of products that cannot be positive.

    Those of points where nothing presses, and of their own normal parts in branches where these are nothing, are zero.
    """

    virtual: Array  # (D, d): T, on the accelerations that the branch leaves
    of_loads: Array  # (l,) of each part that is not negative, by itself
    of_parts: Array  # (l, l) of products of two such parts
    of_forces: Array  # (points, l, 3) k of each part and point, in W
    braking: Array  # (contacts,) of friction, or of all forces where several normals meet
    along: Array  # (contacts, 3) w times that, in W


@dataclass(frozen=True, slots=True, eq=False)
class ProvenBranch:
    """A branch in which nothing starts, with the proof."""

    branch: Branch
    multipliers: Multipliers


def nothing_moves(equations: StartEquations, branch: Branch) -> Multipliers:
    """The proof of a branch that leaves no accelerations."""
    left, points = known(equations, branch), len(equations.normals)
    rows, contacts = len(left.rows), int(equations.contact.max(initial=-1)) + 1
    of_contacts = np.zeros(contacts), np.zeros((contacts, 3))
    return Multipliers(left.basis, np.zeros(rows), np.zeros((rows, rows)), np.zeros((points, rows, 3)), *of_contacts)


def check_branch(equations: StartEquations, proven: ProvenBranch) -> bool:
    """Whether multipliers prove that in their branch nothing starts."""
    return lack(equations, proven) <= STILL


def lack(equations: StartEquations, proven: ProvenBranch) -> float:
    """What rounding leaves of the proof: the largest sum of what coefficients differ by and what signs are short of."""
    left, multipliers = known(equations, proven.branch), proven.multipliers
    if not all(np.isfinite(each).all() for each in _arrays(multipliers)) or not _definite(equations, left, multipliers):
        return np.inf
    of_loads = multipliers.virtual.T @ equations.loads + multipliers.of_loads @ left.rows
    lacks = [_size(of_loads), _negative(multipliers.of_loads), _negative(multipliers.of_parts)]
    for point in left.pressed:
        short = sum(
            _outside(equations, point, multipliers.of_forces[point, row])
            for row, owner in enumerate(left.owners)
            if owner != point
        )
        lacks.append(_size(_coefficients(equations, left, multipliers, point)) + short)
    lacks += [_too_far(equations, multipliers, contact) for contact in sorted(set(equations.contact.tolist()))]
    return float(sum(lacks))


def _arrays(multipliers: Multipliers) -> tuple[Array, ...]:
    of_contacts = (multipliers.braking, multipliers.along)
    return (multipliers.virtual, multipliers.of_loads, multipliers.of_parts, multipliers.of_forces, *of_contacts)


def _definite(equations: StartEquations, left: Known, multipliers: Multipliers) -> bool:
    """Whether T' M less the products of parts is no less than half of M."""
    on_basis = equations.mass @ left.basis
    square = multipliers.virtual.T @ on_basis - left.rows.T @ multipliers.of_parts @ left.rows
    square = 0.5 * (square + square.T) - 0.5 * left.basis.T @ on_basis
    return bool(np.linalg.eigvalsh(square).min(initial=0.0) >= 0.0)


def _coefficients(equations: StartEquations, left: Known, multipliers: Multipliers, point: int) -> Array:
    """(3, d) the coefficients of a force and accelerations that the products leave; along the normal without friction.

    Forces of a point without friction have one component only, and so no others count.
    """
    slip, contact = equations.slips[point] @ left.basis, equations.contact[point]
    rest = equations.slips[point] @ multipliers.virtual + multipliers.of_forces[point].T @ left.rows
    if len(equations.normals[point]) > 1:
        difference: Array = rest - multipliers.braking[contact] * slip
        return difference
    normal = equations.normals[point][0]
    if equations.friction[point] == 0.0:
        pressed: Array = np.outer(normal, normal @ rest)
        return pressed
    across = slip - np.outer(normal, normal @ slip)
    braked = multipliers.braking[contact] * across + np.outer(normal, multipliers.along[contact] @ across)
    left_over: Array = rest - braked
    return left_over


def _outside(equations: StartEquations, point: int, dual: Array) -> float:
    """By how much a vector is outside of the dual of every friction cone of a point."""
    shorts = [0.0]
    for normal in equations.normals[point]:
        along = float(normal @ dual)
        shorts.append(float(equations.friction[point]) * _size(dual - along * normal) - along)
    return max(shorts)


def _too_far(equations: StartEquations, multipliers: Multipliers, contact: int) -> float:
    """By how much the product of friction claims more than friction does."""
    friction = float(equations.friction[int(np.argmax(equations.contact == contact))])
    braking = float(multipliers.braking[contact])
    return max(0.0, -braking, _size(multipliers.along[contact]) - friction * max(braking, 0.0))


def _negative(values: Array) -> float:
    return float(-np.minimum(values, 0.0).sum())


def _size(values: Array) -> float:
    return float(np.sqrt((values * values).sum()))
