"""Quasi-static motion of rigid no-tension blocks by finite displacements: their supports move, or loads are held.

At each amount of movement, the blocks rest in a local minimum of potential energy among all positions that their
contacts permit (Heyman, The Stone Skeleton, 1966). A contact consists of pairs of material points that touch in the
first position. The points of a pair separate but do not overlap; while they press on each other they do not slip, so
that joints open about hinges at their corners. A sequence of conic programs finds the minimum: each is exact for small
displacements from the last point, and its duals are contact forces, which balance the blocks where they are. Newton's
method then closes the contacts to rounding. Where friction does not suffice, contacts slide against the friction that
their pressure permits.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, log10, pi, sqrt
from typing import cast

import numpy as np

from stability.contact_law import Coulomb, OtherLawError
from stability.geometry.placed_shape import bodies_apart, bounds_W, in_place
from stability.geometry.rows import Array, Indices, cross_rows
from stability.geometry.vectors import add, body_axes, inverse, multiply, rotate, scale, subtract
from stability.loads import UNLOADED, Loads
from stability.model import GROUND, BodyId, Pose, Quaternion, Vec3
from stability.problem import Contact, Motion, Placed, Problem
from stability.process_settings import one_thread
from stability.statics.conic_program import ConicProgram, clarabel_solve, solve
from stability.supports import SupportMotion

ACCURACY = 1e-12  # requested of the solver
# Lengths as shares of the size of the structure.
ROOM = 0.05  # how far blocks may move in one program
CLOSED = 1e-8  # contacts at a smaller gap touch
EXACT = 1e-13  # gaps of contacts that touch, after Newton's method
LIFTED = 1e-6  # contacts that open by less while they press stick
SLIPPED = 1e-7  # points that move less in a step stick
ARRIVED = 1e-7  # a program that moves blocks by less has found their rest
STRIDE = 0.01  # how far supports move in one step
FAR = 5.0  # supports that move further find no end
INSIDE = 1e-6  # overlap of bodies that did not touch at first

ALIKE = 1e-6  # heights that differ by less are equal

PRESSED = 1e-8  # share of all weights: smaller forces are noise of the solver
STEADY = 1e-6  # share of all weights: last change of the friction of contacts that slide
FINEST = 1e-10  # share of the amount: between the last rest and the first fall
DOUBT = 5e-7  # share of the amount: how near to the fall the friction of contacts that slide may stay unknown
SPENT = 1e-8  # share of the first factor on loads that push over: what remains is noise
MOST_PROGRAMS = 14  # of a step
MOST_BEYOND = 3  # programs of a step that end at the border of the room: the blocks fall
MOST_ROUNDS = 40  # that find the friction of contacts that slide
AGAIN = 6  # steps after which a stride that was too long is tried again
MOST_STEPS = 2000
ON_FACE = 1e-6  # share of the size of a body: distance of a point from the planes of its faces on which it lies
UPRIGHT = 0.9  # z of a normal above which its tangents refer to the y axis
QUIET = 1e-6  # share of the fastest block: slower ones are noise of the solver
ALONG = 0.5  # cosine of the angle between two sides that face the same way


@dataclass(frozen=True, slots=True)
class Hinge:
    """A joint that has opened about an edge or a corner."""

    lower: BodyId
    upper: BodyId
    point_W: Vec3  # the middle of what still touches [m]


@dataclass(frozen=True, slots=True, eq=False)
class Position:
    """Blocks at rest after some movement, with contact forces that balance them there."""

    amount: float  # share of the movement of the supports, or displacement of the loads along themselves [m]
    poses: Mapping[BodyId, Pose]
    hinges: tuple[Hinge, ...]
    sliding: tuple[tuple[BodyId, BodyId], ...]  # pairs of bodies that slip in this step
    reactions_W: tuple[Vec3, ...]  # force of each support on the bricks [N]
    pressures: Mapping[tuple[BodyId, BodyId], tuple[Vec3, Vec3]]  # by contact: force on the upper body [N], its point
    factor: float = 1.0  # on the loads


@dataclass(frozen=True, slots=True, eq=False)
class LargeMotion:
    """Positions of blocks from the first on, and how their motion ends."""

    positions: Sequence[Position]
    holds: float  # the largest amount at which the blocks rest
    falls: float = inf  # the least amount at which no forces balance them nearby; infinite if that is unknown
    motion: Motion | None = None  # that begins then
    problem: Problem | None = None  # of the last position, whose contacts the motion leaves
    ends: str = ""  # why the motion was not followed further, if it was not


@dataclass(slots=True, eq=False)
class _Blocks:
    """Poses of blocks and supports, and the pairs of material points at which they touch."""

    names: tuple[BodyId, ...]  # of the blocks; supports follow, then the fixed bodies as one
    weights: Array  # (blocks,) [N]
    radius: Array  # (blocks,) [m], which scales turns
    size: float  # of the structure [m]
    lower: Indices  # (pairs,) body of the lower point
    upper: Indices
    points: tuple[Array, Array]  # (pairs, 3) in the axes of the lower and of the upper body
    normals: tuple[Array, Array]  # (pairs, 3) from lower to upper, in the axes of either body; zero if not its own
    friction: Array  # (pairs,)
    contact: Indices  # (pairs,) its contact
    position: Array  # (bodies, 3)
    axes: Array  # (bodies, 3, 3) columns are the axes of a body in W

    def copied(self) -> "_Blocks":
        points = self.points[0].copy(), self.points[1].copy()
        return replace(self, position=self.position.copy(), axes=self.axes.copy(), points=points)

    def _turned(self, vectors: tuple[Array, Array]) -> tuple[Array, Array]:
        below, above = self.axes[self.lower], self.axes[self.upper]
        return np.einsum("ijk,ik->ij", below, vectors[0]), np.einsum("ijk,ik->ij", above, vectors[1])

    def ends(self) -> tuple[Array, Array]:
        """Return the lower and the upper points in W [m]."""
        below, above = self._turned(self.points)
        return self.position[self.lower] + below, self.position[self.upper] + above

    def slips(self) -> Array:
        """Return (pairs, 3) the displacement of upper from lower points along the normal and two tangents [m]."""
        below, above = self.ends()
        slips: Array = np.einsum("pij,pj->pi", self.frames(), above - below)
        return slips

    def frames(self) -> Array:
        """Return (pairs, 3, 3) the unit normals with two tangents, by rows."""
        below, above = self._turned(self.normals)
        normals = below + above
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        reference = np.where(np.abs(normals[:, 2:]) > UPRIGHT, np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
        first = cross_rows(reference, normals)
        first /= np.linalg.norm(first, axis=1)[:, None]
        return np.stack([normals, first, cross_rows(normals, first)], axis=1)

    def slip_matrix(self) -> Array:
        """Return (pairs, 3, 6 blocks) the derivatives of the slips, without those of the frames."""
        n, pairs = len(self.names), len(self.lower)
        matrix = np.zeros((pairs, 3, n + 1, 6))
        rows, each = np.arange(pairs), np.eye(3)
        for body, arm, sign in zip((self.lower, self.upper), self._turned(self.points), (-1.0, 1.0), strict=True):
            which = np.minimum(body, n)
            lengths = np.append(self.radius, 1.0)[which]
            for axis in range(3):
                matrix[rows, axis, which, axis] += sign
                turned = cross_rows(np.tile(each[axis], (pairs, 1)), arm)
                matrix[rows, :, which, 3 + axis] += sign * turned / lengths[:, None]
        turned_all: Array = np.einsum("pij,pjk->pik", self.frames(), matrix[:, :, :n].reshape(pairs, 3, 6 * n))
        return turned_all

    def move(self, step: Array) -> None:
        """Move the blocks by (6 blocks,) shifts, and turns times their radius."""
        n, each = len(self.names), step.reshape(-1, 6)
        self.position[:n] += each[:, :3]
        self.axes[:n] = _rotations(each[:, 3:] / self.radius[:, None]) @ self.axes[:n]

    def place(self, body: int, pose: Pose) -> None:
        self.position[body] = pose.position_W
        self.axes[body] = np.array(body_axes(pose.orientation)).T


def _rotations(vectors: Array) -> Array:
    """Return (n, 3, 3) rotations from (n, 3) rotation vectors, by Rodrigues' formula."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    half = np.sinc(0.5 * angle / pi)
    rotations: Array = np.eye(3) + np.sinc(angle / pi) * cross + 0.5 * half * half * (cross @ cross)
    return rotations


def _quaternion(rotation: Array) -> Quaternion:
    """Return the unit quaternion of a rotation matrix."""
    # The eigenvector of the largest eigenvalue is stable for every angle (Bar-Itzhack, 2000).
    m = rotation
    symmetric = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], m[1, 0] + m[0, 1], m[2, 0] + m[0, 2], m[2, 1] - m[1, 2]],
            [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
            [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    _, vectors = np.linalg.eigh(symmetric / 3.0)
    x, y, z, w = (vectors[:, -1] * (1.0 if vectors[3, -1] >= 0.0 else -1.0)).tolist()
    return x, y, z, w


@dataclass(frozen=True, slots=True, eq=False)
class _Solved:
    """Solution of a program."""

    moved: Array  # (6 blocks,) [m]
    forces: Array  # (pairs, 3) along normal and tangents [N]
    factor: float  # on the loads
    is_bounded: bool  # whether the blocks end within the room


@dataclass(frozen=True, slots=True, eq=False)
class _Rest:
    """Blocks at rest, the forces on them, and the friction of contacts that slide."""

    blocks: _Blocks
    solved: _Solved
    friction: Array | None = None  # (pairs,) [N]; None if none slide


class UnknownRestError(Exception):
    """It is unknown whether the blocks rest."""


class _Search:
    """Finds positions of rest near other ones."""

    def __init__(self, problem: Problem, motions: Sequence[SupportMotion], loads: Loads, held: bool) -> None:
        self.problem, self.motions, self.loads, self.held = problem, motions, loads, held
        self.first = _blocks_of(problem, motions)
        self.unit = float(self.first.weights.sum())
        bricks = problem.bricks
        self.pushes = [(load, bricks[load.brick].pose) for load in loads.loads if load.brick in bricks]
        self.total = sum(float(np.linalg.norm(load.at(pose).force_W)) for load, pose in self.pushes)

    def poses(self, blocks: _Blocks) -> dict[BodyId, Pose]:
        """Return the poses of all blocks."""
        poses = {}
        for index, name in enumerate(blocks.names):
            turned = _quaternion(blocks.axes[index] @ self.first.axes[index].T)
            position = cast(Vec3, tuple(blocks.position[index].tolist()))
            poses[name] = Pose(position, multiply(turned, self.problem.bricks[name].pose.orientation))
        return poses

    def _pushed(self, blocks: _Blocks) -> tuple[Array, Array]:
        """Return (6 blocks,) weights and loads: forces, and torques over the radius [N]."""
        weights, loaded = np.zeros((len(blocks.names), 6)), np.zeros((len(blocks.names), 6))
        weights[:, 2] = -blocks.weights
        if self.pushes:
            for index, (name, pose) in enumerate(self.poses(blocks).items()):
                wrench = self.loads.wrench(Placed(self.problem.bricks[name].brick, pose))
                if wrench is not None:
                    loaded[index] = [*wrench.force_W, *scale(1.0 / blocks.radius[index], wrench.torque_W)]
        return weights.ravel(), loaded.ravel()

    def _displaced(self, blocks: _Blocks) -> float:
        """Return the displacement of the loads along themselves [m]: their work per force."""
        poses, work = self.poses(blocks), 0.0
        for load, first in self.pushes:
            now = poses[load.brick]
            point, before = (add(p.position_W, rotate(p.orientation, load.point_B)) for p in (now, first))
            work += float(np.dot(load.at(first).force_W, subtract(point, before)))
        return work / self.total

    def _program(self, blocks: _Blocks, amount: float, friction: Array | None) -> _Solved | None:
        """Return the displacements with the least potential energy, exact for small ones; None without a solution.

        Without `friction` [N] of contacts that slide, contacts open as fast as they slide times their coefficient.
        """
        from scipy.sparse import csc_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

        room, columns = ROOM * blocks.size, 6 * len(blocks.names)
        matrix, slips = blocks.slip_matrix(), blocks.slips()
        near = np.flatnonzero(slips[:, 0] < 4.0 * sqrt(3.0) * room)
        weights, loaded = self._pushed(blocks)
        cost = -(weights if self.held else weights + loaded) / self.unit
        mu = blocks.friction
        rubs = near[mu[near] > 0.0]
        equal = np.zeros((0, columns))
        offsets = [np.zeros(0)]
        if self.held:
            equal = loaded[None, :] / self.total
            offsets = [np.array([(amount - self._displaced(blocks)) / room])]
        lifted = np.zeros((3 * len(rubs), 0))
        if friction is None:
            flat = near[mu[near] <= 0.0]
            units = np.stack([np.ones(len(rubs)), mu[rubs], mu[rubs]], axis=1)
        else:
            flat = near
            units = np.tile(np.array([0.0, 1.0, 1.0]), (len(rubs), 1))
            lifted = np.kron(np.eye(len(rubs)), np.array([[1.0], [0.0], [0.0]]))
            cost = np.append(cost, friction[rubs] / self.unit)
        round_rows = (units[:, :, None] * matrix[rubs]).reshape(-1, columns)
        box = np.eye(columns)
        moving = np.concatenate([equal, -round_rows, -matrix[flat, 0], box, -box])
        others = np.zeros((len(moving), lifted.shape[1]))
        others[len(equal) : len(equal) + len(lifted)] = -lifted
        offsets += [(units * slips[rubs]).ravel() / room, slips[flat, 0] / room, np.ones(2 * columns)]
        whole = csc_matrix(np.hstack([moving, others]))
        program = ConicProgram(
            cost, whole, np.concatenate(offsets), len(equal), [3] * len(rubs), len(flat) + 2 * columns
        )
        point = solve(program, ACCURACY, clarabel_solve)
        if isinstance(point, str) or not np.isfinite(point.x).all() or not np.isfinite(point.dual).all():
            return None
        if "nfeasible" in point.status:
            return None
        forces = np.zeros((len(mu), 3))
        after = len(equal) + 3 * len(rubs)
        forces[rubs] = units * point.dual[len(equal) : after].reshape(-1, 3)
        forces[flat, 0] = point.dual[after : after + len(flat)]
        factor = -self.unit * float(point.dual[0]) / self.total if self.held else 1.0
        moved = point.x[:columns]
        bounded = float(np.abs(moved).max(initial=0.0)) < 1.0 - CLOSED
        return _Solved(room * moved, self.unit * forces, factor, bounded)

    def _set(self, blocks: _Blocks, amount: float) -> None:
        if not self.held:
            for index, motion in enumerate(self.motions):
                blocks.place(len(blocks.names) + index, motion.at(amount))

    def _close(self, blocks: _Blocks, amount: float, closed: Indices, sticking: Indices) -> None:
        """Close contacts to rounding by Newton's method, with the least displacements."""
        for _ in range(8):
            slips, matrix = blocks.slips(), blocks.slip_matrix()
            rows = [matrix[closed, 0], matrix[sticking, 1], matrix[sticking, 2]]
            rest = [slips[closed, 0], slips[sticking, 1], slips[sticking, 2]]
            if self.held:
                rows.append(self._pushed(blocks)[1][None, :] / self.total)
                rest.append(np.array([self._displaced(blocks) - amount]))
            residual = np.concatenate(rest)
            if np.abs(residual).max(initial=0.0) <= EXACT * blocks.size:
                return
            blocks.move(np.linalg.lstsq(np.concatenate(rows), -residual, rcond=1e-11)[0])

    def _found(self, start: _Blocks, amount: float, friction: Array | None) -> tuple[_Blocks, _Solved] | None:
        """Return the rest nearby after an amount of movement, with the friction of contacts that slide; or None."""
        blocks = start.copied()
        self._set(blocks, amount)
        small, beyond = CLOSED * blocks.size, 0
        for _ in range(MOST_PROGRAMS):
            solved = self._program(blocks, amount, friction)
            if solved is None:
                return None
            predicted = blocks.slips() + blocks.slip_matrix() @ solved.moved
            blocks.move(solved.moved)
            if not solved.is_bounded:
                beyond += 1
                if beyond >= MOST_BEYOND:
                    return None
                continue
            closed = np.flatnonzero(predicted[:, 0] < small)
            slid = np.hypot(predicted[closed, 1], predicted[closed, 2])
            self._close(blocks, amount, closed, closed[slid < SLIPPED * blocks.size])
            if np.abs(solved.moved).max(initial=0.0) < ARRIVED * blocks.size:
                return blocks, solved
        return None

    def rest(self, start: _Blocks, amount: float, friction: Array | None) -> _Rest | None:
        """Return the rest near a position after an amount of movement; None if no forces balance the blocks there.

        `friction` is that of contacts that slid in the last step. Raises UnknownRestError.
        """
        if friction is None:
            found = self._found(start, amount, None)
            if found is None:
                return None
            blocks, solved = found
            lifted = (blocks.slips()[:, 0] > LIFTED * blocks.size) & (solved.forces[:, 0] > PRESSED * self.unit)
            if not lifted.any():
                return _Rest(blocks, solved)
            friction = blocks.friction * solved.forces[:, 0]
        for _ in range(MOST_ROUNDS):
            found = self._found(start, amount, friction)
            if found is None:
                return None
            start = found[0]
            again = start.friction * found[1].forces[:, 0]
            # The points of a contact may share its force in many ways, without an effect on the motion.
            if np.abs(self._by_contact(again - friction)).max(initial=0.0) < STEADY * self.unit:
                return _Rest(*found, friction)
            # The mean settles which of two contacts slides if both could.
            friction = 0.5 * (friction + again)
        raise UnknownRestError("the friction of contacts that slide was not found")

    def _by_contact(self, values: Array) -> Array:
        return np.bincount(self.first.contact, values).astype(np.float64)

    def fall(self, blocks: _Blocks, amount: float) -> Motion | None:
        """Return the motion of blocks that no forces balance after an amount of movement."""
        moved = blocks.copied()
        self._set(moved, amount)
        solved = self._program(moved, amount, None)
        if solved is None:
            return None
        each = solved.moved.reshape(-1, 6) / (ROOM * blocks.size)
        velocity = {
            name: (_vector(row[:3]), _vector(row[3:] / radius))
            for name, row, radius in zip(blocks.names, each, blocks.radius.tolist(), strict=True)
            if np.abs(row).max() > QUIET
        }
        return Motion(velocity)

    # --- what is told about a rest ------------------------------------------------------------------------------------

    def position(self, rest: _Rest, amount: float, slid: Indices) -> Position:
        """Return a rest with its hinges and forces."""
        blocks, solved = rest.blocks, rest.solved
        below, above = blocks.ends()
        middles = 0.5 * (below + above)
        forces = np.einsum("pij,pi->pj", blocks.frames(), solved.forces)
        closed = (blocks.slips()[:, 0] < CLOSED * blocks.size) | (solved.forces[:, 0] > PRESSED * self.unit)
        hinges, pressures = [], {}
        for index, contact in enumerate(self.problem.contacts):
            pairs = np.flatnonzero(blocks.contact == index)
            touching = pairs[closed[pairs]]
            key = contact.lower, contact.upper
            if 0 < len(touching) < len(pairs):
                hinges.append(Hinge(*key, _vector(middles[touching].mean(axis=0))))
            pressed = solved.forces[pairs, 0]
            if pressed.sum() > PRESSED * self.unit:
                point = pressed @ middles[pairs] / pressed.sum()
                pressures[key] = _vector(forces[pairs].sum(axis=0)), _vector(point)
        n = len(blocks.names)
        reactions = [forces[blocks.lower == n + i].sum(axis=0) - forces[blocks.upper == n + i].sum(axis=0)
                     for i in range(len(self.motions))]  # fmt: skip
        sliding = {self.problem.contacts[blocks.contact[pair]] for pair in slid.tolist()}
        names = tuple(sorted((each.lower, each.upper) for each in sliding))
        factor = solved.factor
        return Position(
            amount, self.poses(blocks), tuple(hinges), names, tuple(map(_vector, reactions)), pressures, factor
        )

    def slid(self, rest: _Rest) -> Indices:
        """Return the pairs that have slipped in a step; move the points of pairs to where they touch now."""
        blocks = rest.blocks
        if rest.friction is None:
            return np.zeros(0, dtype=np.int64)
        slips = blocks.slips()
        sizes = np.hypot(slips[:, 1], slips[:, 2])
        pressed = rest.solved.forces[:, 0] > PRESSED * self.unit
        slid = np.flatnonzero((sizes > SLIPPED * blocks.size) & pressed)
        self._follow(blocks, np.flatnonzero(sizes > EXACT * blocks.size))
        return slid

    def _follow(self, blocks: _Blocks, pairs: Indices) -> None:
        """Move one point of each pair along its face to the other one, which is a corner."""
        frames, slips, (below, above) = blocks.frames(), blocks.slips(), blocks.ends()
        for pair in pairs.tolist():
            lift = slips[pair, 0] * frames[pair, 0]
            lower, upper = int(blocks.lower[pair]), int(blocks.upper[pair])
            if self._is_corner_of_upper(blocks, pair, above[pair]):
                foot = above[pair] - lift
                blocks.points[0][pair] = blocks.axes[lower].T @ (foot - blocks.position[lower])
            else:
                foot = below[pair] + lift
                blocks.points[1][pair] = blocks.axes[upper].T @ (foot - blocks.position[upper])

    def _is_corner_of_upper(self, blocks: _Blocks, pair: int, above: Array) -> bool:
        below_has_normal, above_has_normal = (bool(normal[pair].any()) for normal in blocks.normals)
        if below_has_normal is not above_has_normal:
            return below_has_normal
        lower = int(blocks.lower[pair])
        if lower >= len(blocks.names):
            return True
        # Two corners met at first: the one that is still on the face of the other body bears.
        name = blocks.names[lower]
        brick, pose = self.problem.bricks[name].brick, self.poses(blocks)[name]
        inside = rotate(inverse(pose.orientation), subtract(_vector(above), pose.position_W))
        return all(
            float(np.dot(face.normal, inside)) <= brick.shape.reach(face.normal) + ON_FACE * brick.shape.length
            for face in brick.shape.faces
        )


def _vector(row: Array) -> Vec3:
    return cast(Vec3, tuple(row.tolist()))


def _blocks_of(problem: Problem, motions: Sequence[SupportMotion]) -> _Blocks:
    """Return the blocks of a problem in their first position. Raises OtherLawError for joints."""
    names = tuple(sorted(problem.bricks))
    index = {name: i for i, name in enumerate(names)}
    support_of = {name: len(names) + i for i, motion in enumerate(motions) for name in motion.bricks}
    rows: list[tuple[int, int, Vec3, Vec3, bool, bool, float, int]] = []
    for number, contact in enumerate(problem.contacts):
        if not isinstance(contact.law, Coulomb):
            raise OtherLawError("large displacements are not supported for bricks with joints")
        mu = float(contact.law.friction)
        pairs = ((contact.lower, contact.upper), (contact.upper, contact.lower))
        at_rest = len(names) + len(motions)
        fixed = [support_of.get(other, at_rest) if body == GROUND else at_rest for body, other in pairs]
        bodies = index.get(contact.lower, fixed[0]), index.get(contact.upper, fixed[1])
        for point in contact.points_W:
            for normal in contact.normals_W:
                on_lower, on_upper = _faces_of(problem, contact, point, normal)
                rows.append((*bodies, point, normal, on_lower, on_upper, mu, number))
    lower, upper, points, normals, below, above, friction, of = (list(column) for column in zip(*rows, strict=True))
    count = len(names) + len(motions) + 1
    position = np.zeros((count, 3))
    placed = [problem.bricks[name] for name in names]
    position[: len(names)] = [each.pose.position_W for each in placed]
    axes = np.tile(np.eye(3), (count, 1, 1))  # at first, the axes of all bodies are those of W
    lows, highs = zip(*(bounds_W(each.brick.shape, each.pose) for each in placed), strict=True)
    at, along = np.array(points), np.array(normals)
    lower_body, upper_body = np.array(lower), np.array(upper)
    return _Blocks(
        names,
        np.array([float(np.linalg.norm(problem.unloaded.loads[name].force_W)) for name in names]),
        np.array([each.brick.shape.bounding_radius for each in placed]),
        float((np.max(highs, axis=0) - np.min(lows, axis=0)).max()),
        lower_body,
        upper_body,
        (at - position[lower_body], at - position[upper_body]),
        (along * np.array(below)[:, None], along * np.array(above)[:, None]),
        np.array(friction, dtype=float),
        np.array(of),
        position,
        axes,
    )


def _faces_of(problem: Problem, contact: Contact, point: Vec3, normal: Vec3) -> tuple[bool, bool]:
    """Return whether the lower, and the upper body has a face at a point, on which an edge of the other one lies.

    If edges of both meet, both have a face there, and the normal is the mean of their normals.
    """
    lower, upper = problem.bricks.get(contact.lower), problem.bricks.get(contact.upper)
    if lower is None or upper is None:
        return lower is None, upper is None
    below, above = _sides_at(lower, point, normal), _sides_at(upper, point, scale(-1.0, normal))

    def ends(ones: Sequence[Vec3], others: Sequence[Vec3]) -> bool:
        return any(all(np.dot(one, other) < ALONG for other in others) for one in ones)

    lower_ends, upper_ends = ends(below, above), ends(above, below)
    return upper_ends or not lower_ends, lower_ends or not upper_ends


def _sides_at(placed: Placed, point_W: Vec3, outward_W: Vec3) -> list[Vec3]:
    """Return the outward normals in W of the faces at a point, except of the one that looks along `outward_W`."""
    shape, pose = placed.brick.shape, placed.pose
    point_B = rotate(inverse(pose.orientation), subtract(point_W, pose.position_W))
    touched = (
        rotate(pose.orientation, face.normal)
        for face in shape.faces
        if abs(np.dot(face.normal, point_B) - shape.reach(face.normal)) < ON_FACE * shape.length
    )
    return [side for side in touched if np.dot(side, outward_W) < 1.0 - ON_FACE]


@one_thread()
def support_path(
    problem: Problem,
    motions: Sequence[SupportMotion],
    loads: Loads = UNLOADED,
    *,
    until: float = inf,
    on_step: Callable[[float], None] = lambda _: None,
) -> LargeMotion:
    """Return the positions of blocks while their supports move, up to a share of the movement or to the fall.

    The ground below the bricks of each motion moves; all move in proportion. Raises OtherLawError for bricks with
    joints, ValueError for supports that touch no brick or do not move.
    """
    search = _Search(problem, motions, loads, held=False)
    n = len(search.first.names)
    reach = 0.0
    for index, motion in enumerate(motions):
        touching = np.flatnonzero((search.first.lower == n + index) | (search.first.upper == n + index))
        if not len(touching):
            raise ValueError(f"the ground touches none of the bricks {', '.join(motion.bricks)}")
        reach = max(reach, motion.reach([_vector(row) for row in search.first.ends()[0][touching]]))
    if not reach:
        raise ValueError("the supports do not move")
    size = search.first.size
    return _followed(search, min(until, FAR * size / reach), STRIDE * size / reach, on_step)


@one_thread()
def pushover(problem: Problem, loads: Loads, *, on_step: Callable[[float], None] = lambda _: None) -> LargeMotion:
    """Return the positions of blocks that loads push over, with the factor on the loads that holds each.

    The amount is the displacement of the loads along themselves. The curve ends where the factor is zero: beyond, the
    blocks fall by their weight alone. Raises OtherLawError for bricks with joints, ValueError without forces.
    """
    search = _Search(problem, (), loads, held=True)
    if not search.total:
        raise ValueError("no load is a force")
    size = search.first.size
    return _followed(search, FAR * size, STRIDE * size, on_step)


def _followed(search: _Search, until: float, longest: float, on_step: Callable[[float], None]) -> LargeMotion:
    course = _Course(search, search.first, [], stride=min(longest, 0.5 * until))
    # The first step is small: its forces are those of the first position, as the movement begins.
    target = 1e-4 * course.stride
    for _ in range(MOST_STEPS):
        if course.advance(target):
            on_step(course.amount)
            if course.positions[-1].factor <= SPENT * course.positions[0].factor:
                return replace(course.followed(), falls=course.amount)
            if course.amount >= until:
                return course.followed()
            if course.easy >= AGAIN and not course.overturned:
                course.failed, course.stride = inf, min(2.0 * course.stride, longest)
        elif course.ends:
            return course.followed()
        elif course.failed - course.amount <= FINEST * max(course.amount, min(until, longest)):
            return course.fallen()
        target = min(course.amount + course.stride, until, course.between())
    course.ends = f"the motion takes more than {MOST_STEPS} steps"
    return course.followed()


@dataclass(slots=True, eq=False)
class _Course:
    """Blocks on their way."""

    search: _Search
    blocks: _Blocks
    positions: list[Position]
    stride: float
    amount: float = 0.0
    failed: float = inf  # the least amount that was tried in vain since the last easy steps
    overturned: float = 0.0  # the factor there, if it was negative
    easy: int = 0  # steps since then
    friction: Array | None = None  # of contacts that slide
    unknown: str = ""  # why the last step failed, if it is unknown whether the blocks rest
    ends: str = ""

    def followed(self) -> LargeMotion:
        return LargeMotion(self.positions, self.amount, ends=self.ends)

    def advance(self, target: float) -> bool:
        """Move to the next position and return whether blocks rest there."""
        rest = self._rest(target)
        if rest is None:
            self.failed, self.stride, self.easy = target, 0.5 * (target - self.amount), 0
            return False
        if ends := _meeting(self.search, rest.blocks):
            self.ends = ends
            return False
        if self.positions and rest.solved.factor < -SPENT * self.positions[0].factor:
            self.failed, self.overturned, self.easy = target, rest.solved.factor, 0
            self.stride = target - self.amount
            return False
        slid = self.search.slid(rest)
        self.positions.append(self.search.position(rest, target, slid))
        self.blocks, self.friction, self.easy = rest.blocks, rest.friction, self.easy + 1
        self.amount = target
        return True

    def between(self) -> float:
        """Return the amount to try between the last rest and the first failure: a zero of the factor, or the middle."""
        if self.overturned and self.failed < inf:
            factor = self.positions[-1].factor
            return self.amount + (self.failed - self.amount) * factor / (factor - self.overturned)
        return 0.5 * (self.amount + self.failed)

    def _rest(self, target: float) -> _Rest | None:
        self.unknown = ""
        for friction in dict.fromkeys((self.friction is None, True)):
            try:
                rest = self.search.rest(self.blocks, target, None if friction else self.friction)
            except UnknownRestError as error:
                self.unknown = str(error)
                continue
            if rest is not None:
                return rest
        return None

    def fallen(self) -> LargeMotion:
        """Return the end of the motion, at which the blocks fall unless it is unknown whether they rest."""
        falls = self.failed
        if self.unknown:
            falls = self.amount * (1.0 + DOUBT)
            if self._rest(falls) is not None or self.unknown:
                self.ends = self.unknown or "the friction of contacts that slide was not found"
                return self.followed()
        problem = _problem_at(self.search, self.blocks)
        return replace(self.followed(), falls=falls, motion=self.search.fall(self.blocks, falls), problem=problem)


def _problem_at(search: _Search, blocks: _Blocks) -> Problem:
    """Return the problem of the blocks where they are, with the contacts that touch."""
    frames, (below, above), closed = blocks.frames(), blocks.ends(), blocks.slips()[:, 0] < CLOSED * blocks.size
    contacts = []
    for index, contact in enumerate(search.problem.contacts):
        pairs = np.flatnonzero((blocks.contact == index) & closed)
        for pair in pairs.tolist():
            point, normal = _vector(0.5 * (below[pair] + above[pair])), _vector(frames[pair, 0])
            contacts.append(replace(contact, points_W=(point,), normals_W=(normal,), gaps=()))
    poses, digits = search.poses(blocks), round(-log10(blocks.size * ALIKE))
    bricks = {}
    for name, placed in search.problem.bricks.items():
        x, y, z = (round(part, digits) for part in poses[name].position_W)  # so that equal heights are equal
        bricks[name] = replace(placed, pose=replace(poses[name], position_W=(x, y, z)))
    return replace(search.problem, bricks=bricks, contacts=contacts)


def _meeting(search: _Search, blocks: _Blocks) -> str:
    """Return which bodies meet that did not touch at first; empty if none do."""
    poses, bricks = search.poses(blocks), search.problem.bricks
    touching = {frozenset((contact.lower, contact.upper)) for contact in search.problem.contacts}
    placed = [(name, bricks[name].brick.shape, poses[name]) for name in blocks.names]
    bounds = [bounds_W(shape, pose) for _, shape, pose in placed]
    lows, highs = np.array([low for low, _ in bounds]), np.array([high for _, high in bounds])
    inside = INSIDE * blocks.size
    near = (lows[:, None] < highs[None] - inside).all(axis=2) & (lows[None] < highs[:, None] - inside).all(axis=2)
    for one, other in np.argwhere(np.triu(near, 1)).tolist():
        (a, shape, pose), (b, other_shape, other_pose) = placed[one], placed[other]
        if frozenset((a, b)) in touching:
            continue
        if bodies_apart(in_place(shape, pose), in_place(other_shape, other_pose)).gap < -inside:
            return f"{a} meets {b}"
    return ""
