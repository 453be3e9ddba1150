"""The matrix from contact forces to wrenches on bricks; its transpose maps velocities to slips.

It is scaled so that a conic solver sees numbers near one, for any size, density, gravity and place of the structure:
the balance of a brick is divided by its load capacity, torques also by its half diagonal, and a contact force by the
load capacity of its upper body. All positions are relative to the bricks' centres. `proof` shares no code with it.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from math import hypot
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stability.contact_law import OtherLawError
from stability.geometry.rows import Array, Indices, cross_rows
from stability.model import BodyId, Vec3
from stability.problem import ZERO, ConeForces, Forces, Motion, Problem, Wrench
from stability.statics.bounded_rows import BoundedRows, bounded_rows
from stability.statics.cone_rows import ConeRows, row_units, with_and_without
from stability.work_limit import add_matrix

Sparse: TypeAlias = Any  # scipy's matrices have no types

NO_LOAD = Wrench(ZERO)
CENTRAL = 0.9  # a normal with a vertical part up to this takes the vertical as the reference of its tangents


@dataclass(frozen=True, slots=True, eq=False)
class Cones:
    """Friction cones of a problem: by contact, point and normal, in this order."""

    shapes: tuple[tuple[int, int], ...]  # per contact: numbers of points, and of normals at each
    lower: Indices  # (n,) index of the brick below; the number of bricks for a fixed body
    upper: Indices
    points_W: Array  # (n, 3) [m]
    axes_W: Array  # (n, 3, 3) the unit normal and two tangents, by rows
    friction: Array  # (n,) 1 for a law without friction that is no cone, as it bears tangential forces nevertheless
    tips_W: Array  # (n, 3) [N] force at the tip of the cone: zero, or a pull


@dataclass(frozen=True, slots=True, eq=False)
class WrenchMatrix:
    """Rows: slips of the cones with friction (normal and two tangents), then normal slips of those without.

    Columns: the three components of each brick's velocity, then of its spin, without those that no force affects. With
    slips `S = matrix @ u`, forces `f` in units of `row_scale` balance loads if `matrix.T @ f + loads = 0`.

    The rows hold the forces above the tips of the cones; the pulls at the tips count as loads. The last rows without
    friction are the tensions of ties above their least ones, up to `most_tension`.
    """

    names: tuple[BodyId, ...]
    cones: Cones
    matrix: Sparse  # (rows, columns)
    loads: Array  # (columns,)
    rows: ConeRows
    round: Indices  # the cones with friction, in the order of their rows
    flat: Indices  # the cones without
    row_scale: Array  # (rows,) unit of force [N]
    column_scale: Array  # (6 bricks,) unit of force or torque [N, N m]
    kept: Indices  # (columns,) their indices among the 6 bricks
    pulls: Array  # (columns,) of the forces at the tips of the cones
    bounded: BoundedRows | None = None  # the points with a law that is no cone, if any law was admitted
    most_tension: Array = field(default_factory=partial(np.zeros, 0))  # (ties,) in units of their rows

    @property
    def of_ties(self) -> slice:
        """Return the rows of ties."""
        return slice(len(self.rows) - len(self.most_tension), len(self.rows))

    def project(self, rows: Array) -> Array:
        """Return the nearest forces that all contacts can bear."""
        nearest = self.rows.project(rows)
        nearest[self.of_ties] = np.minimum(nearest[self.of_ties], self.most_tension)
        return nearest if self.bounded is None else self.bounded.project(rows, nearest)

    def room(self, rows: Array) -> Array:
        """Return by row the distance of its normal force from the least one."""
        normal = rows[self.rows.normals]
        room = self.rows.by_row(normal if self.bounded is None else self.bounded.above_least(normal))
        room[self.of_ties] = np.minimum(room[self.of_ties], self.most_tension - room[self.of_ties])
        return room

    def opening(self, columns: Array) -> tuple[Array, Sparse]:
        """Return by cone the excess of its opening speed over the least one for bounded power, and the derivatives."""
        from scipy.sparse import csr_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

        rows = self.matrix @ columns
        slope = np.ones(self.rows.round)
        if self.bounded is not None:
            slope[self.bounded.cones] = self.bounded.lift
        triples = self.rows.triples(rows)
        sliding = np.hypot(triples[:, 1], triples[:, 2])
        along = slope[:, None] * triples[:, 1:] / np.where(sliding > 0.0, sliding, 1.0)[:, None]
        factors = np.append(np.column_stack([np.ones(len(along)), -along]).ravel(), np.ones(self.rows.flat))
        cones = np.append(np.repeat(np.arange(self.rows.round), 3), self.rows.round + np.arange(self.rows.flat))
        gather = csr_matrix((factors, (cones, np.arange(len(factors)))), shape=(len(self.rows.normals), len(factors)))
        excess = np.append(triples[:, 0] - slope * sliding, self.rows.singles(rows))
        return excess, (gather @ self.matrix).tocsr()

    def wrench_of(self, wrenches: Mapping[BodyId, Wrench]) -> Array:
        """Return wrenches on bricks, in the units and order of the columns."""
        columns: Array = (wrench_array(self.names, wrenches).ravel() / self.column_scale)[self.kept]
        return columns

    def forces(self, rows: Array) -> Forces:
        """Return contact forces from the forces of the rows."""
        tensions = rows[self.of_ties] * self.row_scale[self.of_ties]
        return Forces(grouped(self.cones.shapes, self.forces_W(rows)), tuple(tensions.tolist()))

    def forces_W(self, rows: Array) -> Array:
        """Return (cones, 3) the same forces as one array [N]."""
        rows = rows * self.row_scale
        forces = np.zeros((len(self.cones.lower), 3))
        forces[self.round] = np.einsum("ij,ijk->ik", self.rows.triples(rows), self.cones.axes_W[self.round])
        forces[self.flat] = self.rows.singles(rows)[: len(self.flat), None] * self.cones.axes_W[self.flat, 0]
        return forces + self.cones.tips_W

    def greatest_forces(self, rows: Array) -> dict[BodyId, float]:
        """Return the greatest contact force on each brick [N], or its load if that is greater."""
        sizes = np.append(self.column_scale[0::6], 0.0)
        forces = np.sqrt(np.square(self.forces_W(rows)).sum(axis=1))
        for bodies in (self.cones.lower, self.cones.upper):
            np.fmax.at(sizes, bodies, np.where(np.isfinite(forces), forces, 0.0))
        return dict(zip(self.names, sizes[:-1].tolist(), strict=True))

    def rows_of(self, forces_W: Array) -> Array:
        """Return the forces of the rows from the contact force of each cone [N]."""
        axes, forces_W = self.cones.axes_W, forces_W - self.cones.tips_W
        triples = np.einsum("ij,ikj->ik", forces_W[self.round], axes[self.round])
        singles = np.einsum("ij,ij->i", forces_W[self.flat], axes[self.flat, 0])
        rows: Array = self.rows.joined(triples, singles) / self.row_scale
        return rows

    def motion(self, columns: Array, quiet: float = 0.0) -> Motion:
        """Return velocities from the columns; a brick slower than a share `quiet` of the fastest is static."""
        velocity = np.zeros(len(self.column_scale))
        velocity[self.kept] = columns
        velocity = velocity / self.column_scale
        by_brick = velocity.reshape(-1, 6)
        lengths = (self.column_scale[3::6] / self.column_scale[0::6])[:, None]
        speed = np.maximum(np.abs(by_brick[:, :3]), np.abs(by_brick[:, 3:]) * lengths).max(axis=1, initial=0.0)
        fastest = speed.max(initial=0.0)
        if not 0.0 < fastest < np.inf:
            return Motion({})
        moving = np.flatnonzero(speed > quiet * fastest).tolist()
        values = (by_brick / fastest).tolist()
        return Motion({self.names[i]: (tuple(values[i][:3]), tuple(values[i][3:])) for i in moving})

    def unscaled_motion(self, columns: Array) -> Motion:
        """Return velocities of all bricks from the columns, in SI and not relative to the fastest."""
        return motion_of(self.names, self.velocity(columns))

    def velocity(self, columns: Array) -> Array:
        """Return (bricks, 6) velocities and spins from the columns [m/s, rad/s]."""
        velocity = np.zeros(len(self.column_scale))
        velocity[self.kept] = columns
        return (velocity / self.column_scale).reshape(-1, 6)

    def columns_of(self, motion: Motion) -> Array:
        """Return velocities of bricks, in the units and order of the columns."""
        rows = [motion.velocity.get(name, (ZERO, ZERO)) for name in self.names]
        columns: Array = (np.array(rows, dtype=float).reshape(-1) * self.column_scale)[self.kept]
        return columns


def wrench_matrix(
    problem: Problem, whole: bool = False, carried: Mapping[BodyId, float] | None = None, *, any_law: bool = False
) -> WrenchMatrix:
    """Return the matrix of a problem; if `whole`, with all columns, for other loads than its own.

    `carried` is the load capacity of each brick [N]; by default the load passed down to it. With `any_law` contacts may
    have any law: the points of a law that is no cone have three rows and no tip, and the caller limits their forces,
    as those of ties. Without it, raises OtherLawError for ties of unknown tension.
    """
    if problem.ties and not any_law:
        raise OtherLawError("this analysis is not supported for ties of unknown tension")
    names = tuple(sorted(problem.bricks))
    add_matrix(sum(len(c.points_W) * len(c.normals_W) for c in problem.contacts))
    cones = cones_of(problem, names, any_law=any_law)
    force, length = _brick_scales(problem, names, passed_down(problem) if carried is None else carried)
    with_friction, without = with_and_without(cones.friction)
    contacts = ConeRows(len(with_friction), len(without))
    rows = ConeRows(contacts.round, contacts.flat + len(problem.ties))
    row_cone = contacts.by_row(np.append(with_friction, without))
    axis = contacts.joined(np.tile(np.arange(3), (contacts.round, 1)), np.zeros(contacts.flat, dtype=np.int64))
    held = np.where(cones.upper < len(names), cones.upper, cones.lower)
    row_scale = np.append(force, 1.0)[held][row_cone] * row_units(cones.friction)[row_cone, axis]
    index = {name: i for i, name in enumerate(names)}
    tie_scale = np.array([max(force[index[name]] for name in tie.pulls) for tie in problem.ties])
    row_scale = np.append(row_scale, tie_scale)
    column_scale = np.stack([force, force, force, *[force * length] * 3], axis=1).ravel()
    pulls = _pulls(problem, names, cones).ravel() / column_scale
    loads = wrench_array(names, problem.loads).ravel() / column_scale + pulls
    acts = np.ones(len(loads), dtype=bool) if whole else loads != 0.0
    entries = _matrix(problem, names, cones, row_cone, axis)
    if problem.ties:
        entries = _with_ties(problem, names, entries)
    matrix, kept = _kept(entries, acts, row_scale, column_scale)
    limits = bounded_rows(problem.contacts, with_friction, row_scale) if any_law else None
    return WrenchMatrix(
        names,
        cones,
        matrix,
        loads[kept],
        rows,
        with_friction,
        without,
        row_scale,
        column_scale,
        kept,
        pulls[kept],
        limits,
        np.array([tie.more for tie in problem.ties]) / tie_scale,
    )


def cones_of(problem: Problem, names: Sequence[BodyId], *, any_law: bool = False) -> Cones:
    """Return the friction cones of a problem; bricks are numbered as in `names`.

    Unless `any_law`, raises OtherLawError for a contact law other than a Coulomb cone, with its tip anywhere on
    the normal.
    """
    index = {name: i for i, name in enumerate(names)}
    contacts = problem.contacts
    shapes = tuple((len(c.points_W), len(c.normals_W)) for c in contacts)
    sizes = np.array([points * normals for points, normals in shapes], dtype=np.int64)
    points_W = [point for c in contacts for point in c.points_W for _ in c.normals_W]
    normals_W = [normal for c in contacts for _ in c.points_W for normal in c.normals_W]

    for contact in contacts:
        if not (any_law or contact.law.is_shifted_cone):
            law = f"'{contact.upper}' on '{contact.lower}' has the law {type(contact.law).__name__}"
            raise OtherLawError(
                f"this analysis is not supported for bricks with joints: {law}, which is no Coulomb cone"
            )

    def spread(values: list[int] | list[float]) -> Any:  # noqa: ANN401 -- integers or floats
        return np.repeat(np.array(values), sizes)

    axes_W = _axes(np.array(normals_W, dtype=float).reshape(-1, 3))
    tips = spread([0.0 if any_law else c.law.least_normal for c in contacts]).astype(float)
    return Cones(
        shapes,
        spread([index.get(c.lower, len(names)) for c in contacts]).astype(np.int64),
        spread([index.get(c.upper, len(names)) for c in contacts]).astype(np.int64),
        np.array(points_W, dtype=float).reshape(-1, 3),
        axes_W,
        spread([c.law.friction or float(any_law and not c.law.is_cone) for c in contacts]).astype(float),
        tips[:, None] * axes_W[:, 0],
    )


def _pulls(problem: Problem, names: Sequence[BodyId], cones: Cones) -> Array:
    """Return (bricks, 6) forces and torques of the forces at the tips of the cones [N, N m]."""
    wrenches = np.zeros((len(names) + 1, 6))  # the last row is that of the fixed bodies
    if cones.tips_W.any():
        centres = np.array([problem.bricks[name].pose.position_W for name in names] + [ZERO], dtype=float)
        for body, sign in ((cones.upper, 1.0), (cones.lower, -1.0)):
            forces = sign * cones.tips_W
            np.add.at(wrenches, body, np.hstack([forces, cross_rows(cones.points_W - centres[body], forces)]))
    return wrenches[:-1]


def _axes(normals: Array) -> Array:
    """Return each unit normal with two tangents."""
    upright = np.abs(normals[:, 2]) > CENTRAL
    reference = np.where(upright[:, None], np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    first = cross_rows(reference, normals)
    first /= np.sqrt(np.einsum("ij,ij->i", first, first))[:, None]
    return np.stack([normals, first, cross_rows(normals, first)], axis=1)


def _matrix(
    problem: Problem, names: Sequence[BodyId], cones: Cones, row_cone: Indices, axis: Indices
) -> tuple[Array, Indices]:
    """Return by row the twelve entries of the two bodies, unscaled, and their columns; 6 bricks for a fixed body."""
    centres = np.array([problem.bricks[name].pose.position_W for name in names] + [ZERO], dtype=float)
    direction = cones.axes_W[row_cone, axis]
    points = cones.points_W[row_cone]
    entries, columns = [], []
    for body, sign in ((cones.upper[row_cone], 1.0), (cones.lower[row_cone], -1.0)):
        signed = sign * direction
        entries += [signed, cross_rows(points - centres[body], signed)]
        columns.append(np.minimum(body[:, None] * 6 + np.arange(6), 6 * len(names)))
    return np.concatenate(entries, axis=1), np.concatenate(columns, axis=1)


def _with_ties(problem: Problem, names: Sequence[BodyId], of_contacts: tuple[Array, Indices]) -> tuple[Array, Indices]:
    """Return entries and columns as `_matrix`, with a row of all bricks for each tie."""
    entries, columns = of_contacts
    width = max(entries.shape[1], 6 * max(len(tie.pulls) for tie in problem.ties))
    more = width - entries.shape[1]
    rows, places = np.zeros((len(problem.ties), width)), np.full((len(problem.ties), width), 6 * len(names))
    for number, tie in enumerate(problem.ties):
        bricks = sorted(tie.pulls)
        own = wrench_array(bricks, tie.pulls).ravel()
        rows[number, : len(own)] = own
        at = np.array([names.index(name) for name in bricks])
        places[number, : len(own)] = (6 * at[:, None] + np.arange(6)).ravel()
    wider = np.pad(entries, ((0, 0), (0, more))), np.pad(columns, ((0, 0), (0, more)), constant_values=6 * len(names))
    return np.concatenate([wider[0], rows]), np.concatenate([wider[1], places])


def _kept(
    unscaled: tuple[Array, Indices], acts: NDArray[np.bool_], row_scale: Array, column_scale: Array
) -> tuple[Sparse, Indices]:
    """Return the scaled matrix without the columns that no force affects, and the remaining columns."""
    from scipy.sparse import csr_matrix  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    entries, columns = unscaled
    used = (entries != 0.0) & (columns < len(acts))
    acts[columns[used]] = True
    kept = np.flatnonzero(acts)
    entries = entries * row_scale[:, None] / np.append(column_scale, 1.0)[columns]
    number = np.cumsum(acts) - 1
    starts = np.zeros(len(entries) + 1, dtype=np.int32)
    np.cumsum(used.sum(axis=1), out=starts[1:])
    shape = (len(entries), len(kept))
    return csr_matrix((entries[used], number[columns[used]].astype(np.int32), starts), shape=shape).tocsc(), kept


def _brick_scales(problem: Problem, names: Sequence[BodyId], weights: Mapping[BodyId, float]) -> tuple[Array, Array]:
    """Return the load capacity [N] and the half diagonal [m] of each brick."""
    force = np.array([weights[name] for name in names], dtype=float)
    largest = force.max(initial=0.0)
    force = np.where(force > 0.0, force, largest if largest > 0.0 else 1.0)
    return force, np.array([problem.bricks[name].brick.shape.bounding_radius for name in names], dtype=float)


def passed_down(problem: Problem) -> dict[BodyId, float]:
    """Return an estimate of the load of each brick [N]: its own, and the loads from above in equal shares."""
    heights = {name: placed.pose.position_W[2] for name, placed in problem.bricks.items()}
    below: dict[BodyId, list[BodyId]] = {name: [] for name in heights}
    for contact in problem.contacts:
        if contact.upper in below:
            below[contact.upper].append(contact.lower)
    carried = {name: magnitude(problem, name) for name in heights}
    for name in sorted(heights, key=lambda brick: (-heights[brick], brick)):
        for lower in below[name]:
            if heights.get(lower, heights[name]) < heights[name]:
                carried[lower] += carried[name] / len(below[name])
    return carried


def magnitude(problem: Problem, name: BodyId) -> float:
    """Return the size of the load on a brick [N]; its torque counts as a force at half a diagonal."""
    load = problem.loads.get(name, NO_LOAD)
    arm = problem.bricks[name].brick.shape.bounding_radius
    return hypot(*load.force_W) + hypot(*load.torque_W) / arm


def wrench_array(names: Sequence[BodyId], wrenches: Mapping[BodyId, Wrench]) -> Array:
    """Return (bricks, 6) forces and torques."""
    rows = [wrenches.get(name, NO_LOAD) for name in names]
    return np.array([(*row.force_W, *row.torque_W) for row in rows], dtype=float).reshape(-1, 6)


def grouped(shapes: Sequence[tuple[int, int]], forces: Array) -> tuple[ConeForces, ...]:
    """Return forces by contact, point and normal."""
    each: Iterator[Vec3] = map(tuple, forces.tolist())
    return tuple(tuple(tuple(islice(each, normals)) for _ in range(points)) for points, normals in shapes)


def flattened(forces: Forces) -> Array:
    """Return (n, 3) forces by contact, point and normal as one array [N]."""
    return np.array([each for of in forces.of_contacts for by_normal in of for each in by_normal]).reshape(-1, 3)


def motion_of(names: Sequence[BodyId], velocity: Array) -> Motion:
    """Return the motion of bricks from (bricks, 6) velocities and spins [m/s, rad/s]."""
    by_brick = zip(names, velocity.tolist(), strict=True)
    return Motion({name: ((a, b, c), (d, e, f)) for name, (a, b, c, d, e, f) in by_brick})
