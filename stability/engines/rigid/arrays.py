"""Arrays of the rigid-body engine, in SI units, and the compilation of the functions that work on them."""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Return the function as machine code, which is kept for later processes."""
    return cast("Function", njit(cache=True, error_model="numpy")(function))


class Bodies(NamedTuple):
    """Rigid bodies: bricks and welded groups, and last the world, which rests and has no mass.

    Body axes are the principal axes of inertia.
    """

    position: Array  # (n, 3) of the centre of mass, W [m]
    turn: Array  # (n, 4) from body axes to W: x, y, z, w
    motion: Array  # (n, 6) velocity [m/s] and spin [rad/s], W
    axes: Array  # (n, 9) rotation matrix by rows
    inverse_mass: Array  # (n,) [1/kg]; 0 of frozen and carried bodies
    inverse_moments: Array  # (n, 3) [1/(kg m2)]
    response: Array  # (n, 6) inverse inertia in W: xx, xy, xz, yy, yz, zz
    force: Array  # (n, 3) from outside the engine [N]
    torque: Array  # (n, 3) [N m]
    reach: Array  # (n,) of the farthest corner from the centre [m]
    # (n, 7) of slid bodies: 1, their velocity [m/s], and the unit axis along which they move freely; else 0
    guide: Array


class Solids(NamedTuple):
    """Convex solids of the bodies, in body axes. Index ranges run from `first[i]` to `first[i + 1]`."""

    body: Ints  # (s,)
    surface: Ints  # (s,) row of `friction`
    radius: Array  # (s,) edge radius [m]
    corner: Ints  # (s + 1,) first corner
    corners: Array  # (c, 3) [m]
    cores: Array  # (c, 3) corners of the solid without its rounded edges [m]
    face: Ints  # (s + 1,) first face
    normals: Array  # (f, 3) outward
    heights: Array  # (f,) of the faces over the centre of mass of the body [m]
    loop: Ints  # (f + 1,) first corner of each face in `loops`
    loops: Ints  # corners of the faces, counted from the first of the solid, counter-clockwise seen from outside
    edge: Ints  # (s + 1,) first edge
    edges: Ints  # (e, 2) corners, counted from the first of the solid
    friction: Array  # (k, k) of surfaces on each other
    planes: Array  # (p, 4) outward normals and heights of half-spaces
    on_planes: Array  # (k, p) friction of surfaces on half-spaces


class Points(NamedTuple):
    """Contact points, sorted by pair of solids, those on half-spaces first."""

    solids: Ints  # (n, 2) that touch; the first is -1, -2, ... for half-spaces
    bodies: Ints  # (n, 2) of these; the first is the world for half-spaces
    key: Ints  # (n,) of the features that touch
    row: Array  # (n, WIDTH) all else, in the columns below


# Columns of a contact point. The normal points from the first to the second body; the frame is in W.
NORMAL, ALONG, ACROSS = 0, 3, 6
ON_FIRST, ON_SECOND = 9, 12  # the point in axes of either body [m]
OFFSET = 15  # gap less the distance of the two points along the normal [m]
FRICTION = 16
PRESSES, RUBS, RUBS_ACROSS = 17, 18, 19  # impulses [N s]
MASS, MASS_ACROSS = 20, 21  # effective masses [kg]
ARM_FIRST, ARM_SECOND = 22, 25  # from the centres, W [m]
GAP = 28  # [m]
FRESH = 29  # 1 of points that were not there in the last step
DRAGS, DRAGS_ACROSS = 30, 31  # slips along the two tangents after a unit of normal impulse [1/kg]
TURNS = 32  # spins of the first, then of the second body after unit impulses along the three axes [1/(kg m)]
WIDTH = 50


def no_points(most: int) -> Points:
    """Return room for contact points."""
    pairs = np.zeros((most, 2), np.int64)
    return Points(pairs, pairs.copy(), np.zeros(most, np.int64), np.zeros((most, WIDTH)))
