"""Linear programs with few variables for structures of studded bricks.

A stud pulls up to a bound, and holds sideways up to a bound at any normal force. It may as well pull as strongly as it
can: the corners of its contact, which press, balance the rest. So the points of all studs of a joint are replaced by
their greatest pull, which is constant, and by two forces and a torque along the contact. Dry contacts press without
friction; such forces are free of self-stress (`self_stress`).

With vertical forces alone, three equations a brick and four variables a joint remain, and these forces often bear as
much as any others. Forces along the contacts are as small as possible, since the program does not bound them. All
bounds, and friction in a motion, are left to the checks of `proof`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf
from typing import Final

import numpy as np

from stability.contact_law import MohrCoulomb
from stability.geometry.rows import Array, Indices, cross_rows
from stability.geometry.vectors import scale
from stability.model import BodyId, Vec3
from stability.problem import Contact, Forces, Motion, Problem
from stability.statics.conic_program import INFEASIBLE, ConicProgram, Solver, clarabel_solve, quick_solve, solve
from stability.statics.proof import contact_rows
from stability.statics.wrench_matrix import grouped, wrench_array

ACCURACY: Final = 1e-12  # requested
LEVEL: Final = 0.999  # vertical part of the normal of a contact that bears vertical forces
SMALL: Final = 0.01  # cost of forces along all joints as large as their pull or their bound
MOVES: Final = 1e-6  # of the fastest speed: slower bricks are noise of the solver
VERTICAL: Final = (2, 3, 4)  # components of velocity and spin, or of force and torque, with vertical forces
WEAK: Final = 1e-6  # of the usual load: studs that hold less sideways count like this in the cost
SHORTEST: Final = 1e-60  # [m]


@dataclass(frozen=True, eq=False)
class _Points:
    """Points of all contacts of a problem, and of the joints among them."""

    shapes: tuple[tuple[int, int], ...]  # per contact: numbers of points, and of normals at each
    bodies: Indices  # (points, 2) lower and upper brick; -1 for a fixed body
    points_W: Array  # (points, 3)
    normals_W: Array  # (points, 3)
    dry: Indices  # points that press
    held: Indices  # (studs,) points of studs
    joint: Indices  # (studs,) their joints
    count: Indices  # (joints,) of their points
    pull: Array  # (joints,) of each point [N]
    shear: Array  # (joints,) likewise

    @classmethod
    def of(cls, problem: Problem, names: Sequence[BodyId]) -> "_Points":
        """Return the points."""
        contacts, index = problem.contacts, {name: i for i, name in enumerate(names)}
        points_W, normals_W, sizes = contact_rows(contacts)
        bodies = np.array([(index.get(c.lower, -1), index.get(c.upper, -1)) for c in contacts], dtype=np.int64)
        presses = [c.law.is_cone and len(c.normals_W) == 1 for c in contacts]
        is_joint = np.array([not c.law.is_cone for c in contacts], dtype=bool)
        laws = [c.law for c in contacts if not c.law.is_cone]
        strengths = {law: (-float(law.least_normal), float(law.greatest_friction(0.0))) for law in set(laws)}
        pull, shear = np.array([strengths[law] for law in laws]).reshape(-1, 2).T
        count = sizes[is_joint]
        return cls(
            tuple((len(c.points_W), len(c.normals_W)) for c in contacts),
            np.repeat(bodies.reshape(-1, 2), sizes, axis=0),
            points_W,
            normals_W,
            np.flatnonzero(np.repeat(np.array(presses, dtype=bool), sizes)),
            np.flatnonzero(np.repeat(is_joint, sizes)),
            np.repeat(np.arange(len(laws)), count),
            count,
            pull,
            shear,
        )

    def level(self) -> "_Points":
        """Return the same with only those points that press vertically."""
        return replace(self, dry=self.dry[self.normals_W[self.dry, 2] >= LEVEL])

    @cached_property
    def first(self) -> Indices:
        """Return (joints,) the first of their points among those of studs."""
        return np.cumsum(self.count) - self.count

    @cached_property
    def normal_W(self) -> Array:
        """Return (joints, 3) the normal of each joint."""
        return self.normals_W[self.held][self.first]

    @cached_property
    def middle_W(self) -> Array:
        """Return (joints, 3) the centre of the points of each joint."""
        sums = [np.bincount(self.joint, part, minlength=len(self.pull)) for part in self.points_W[self.held].T]
        return np.stack(sums, axis=1) / self.count[:, None]

    @cached_property
    def on(self) -> Indices:
        """Return (joints, 2) the lower and the upper brick of each joint."""
        return self.bodies[self.held][self.first]

    @cached_property
    def arms(self) -> Array:
        """Return (studs, 3) the way from the middle of the joint to each point [m]."""
        arms: Array = self.points_W[self.held] - self.middle_W[self.joint]
        return arms

    @cached_property
    def reach(self) -> Array:
        """Return (joints,) the root of the square sum of these ways [m]."""
        squares = np.bincount(self.joint, np.square(self.arms).sum(axis=1), minlength=len(self.pull))
        return np.sqrt(np.maximum(squares, SHORTEST * SHORTEST))

    @cached_property
    def along_W(self) -> Array:
        """Return (studs, 3, 3) the forces of each point for a unit of two forces along its joint and of a torque."""
        one = cross_rows(np.identity(3)[np.abs(self.normal_W).argmin(axis=1)], self.normal_W)
        one /= (np.sqrt(np.square(one).sum(axis=1)) * self.count)[:, None]
        other = cross_rows(self.normal_W, one)
        turned = cross_rows(self.normal_W[self.joint], self.arms) / self.reach[self.joint][:, None]
        return np.stack([one[self.joint], other[self.joint], turned], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class StudPoint:
    """Point of a solver, unproven."""

    share: float  # of the pull of all studs: the inverse of the load factor; inf if no pull is enough
    names: tuple[BodyId, ...]
    velocity: Array  # (bricks, 6) of the first mechanism [1/m, 1]; with vertical forces only its components `VERTICAL`
    speed: Array  # (bricks,) relative to the fastest brick
    is_whole: bool  # the velocity has all components, and no joint slips
    _points: _Points
    _pressed: Array  # (dry points,) [N]
    _along: Array  # (joints, 3) [N]; empty for vertical forces

    def forces(self, factor: float = 1.0) -> Forces:
        """Return the forces that balance the loads times a factor."""
        points = self._points
        forces = np.zeros_like(points.normals_W)
        forces[points.dry] = self._pressed[:, None] * points.normals_W[points.dry]
        forces[points.held] = -self.share * points.pull[points.joint][:, None] * points.normals_W[points.held]
        if len(self._along):
            forces[points.held] += np.einsum("ij,ijk->ik", self._along[points.joint], points.along_W)
        return Forces(grouped(points.shapes, factor * forces))

    def moving(self, quiet: float) -> list[BodyId]:
        """Return the bricks that the first mechanism moves faster than this share of the fastest one."""
        return [self.names[i] for i in np.flatnonzero(self.speed > quiet).tolist()]

    def motion(self) -> Motion:
        """Return the first mechanism."""
        values = dict(zip(self.names, self.velocity.tolist(), strict=True))
        return Motion({name: (tuple(values[name][:3]), tuple(values[name][3:])) for name in self.moving(MOVES)})


@dataclass(frozen=True, slots=True)
class StudProgram:
    """Choice of a program and its solver; see `_solved`."""

    vertical: bool
    sparing: bool
    solver: Solver = quick_solve


UPRIGHT: Final = StudProgram(vertical=True, sparing=True)
WHOLE: Final = StudProgram(vertical=False, sparing=False)
SPARING: Final = StudProgram(vertical=False, sparing=True)
REFINED: Final = StudProgram(vertical=False, sparing=True, solver=clarabel_solve)


@dataclass(eq=False)
class StudPrograms:
    """Programs of one problem."""

    problem: Problem

    @cached_property
    def _places(self) -> "_Places":
        return _Places.of(self.problem)

    def point(self, program: StudProgram) -> StudPoint | None:
        """Return the point of a program; None if there is no such program for the problem, or it is not solved."""
        if not _applies(self.problem, program.vertical):
            return None
        return _solved(self._places, vertical=program.vertical, sparing=program.sparing, solver=program.solver)


def stud_points(problem: Problem) -> Iterator[StudPoint]:
    """Yield the points of the programs, those with the fewest steps of the solver first."""
    programs = StudPrograms(problem)
    points = (programs.point(program) for program in (UPRIGHT, WHOLE, SPARING, REFINED))
    return (point for point in points if point is not None)


def whole_point(problem: Problem) -> StudPoint | None:
    """Return the point with the largest load factor; None if there is no program for a problem, or it is not solved."""
    return _solved(_Places.of(problem), vertical=False, sparing=False) if _applies(problem, level=False) else None


def _applies(problem: Problem, level: bool) -> bool:
    return all(contact.law.is_cone or _is_flat(contact, level) for contact in problem.contacts)


@dataclass(frozen=True, slots=True, eq=False)
class _Places:
    """Bricks of a problem, their loads, and the points of its contacts."""

    names: tuple[BodyId, ...]
    loads: Array  # (bricks, 6)
    lengths: Array  # (bricks,) [m]
    centres_W: Array  # (bricks, 3)
    points: _Points

    @classmethod
    def of(cls, problem: Problem) -> "_Places":
        names = tuple(sorted(problem.bricks))
        return cls(
            names,
            wrench_array(names, problem.loads),
            np.array([problem.bricks[name].brick.shape.bounding_radius for name in names]),
            np.array([problem.bricks[name].pose.position_W for name in names]),
            _Points.of(problem, names),
        )


def _solved(places: _Places, *, vertical: bool, sparing: bool, solver: Solver = quick_solve) -> StudPoint | None:
    """Return the point of the program; None if it is not solved.

    With `vertical`, forces are vertical. Unless `sparing`, forces along the joints have no cost, and no joint slips in
    the motion: with a cost it slips in proportion to its force.
    """
    names, loads, lengths, centres_W = places.names, places.loads, places.lengths, places.centres_W
    unit = float(np.sqrt(np.square(loads[:, :3]).sum(axis=1)).mean()) or 1.0
    points = places.points.level() if vertical else places.points
    columns = _Columns.of(points, unit, vertical=vertical)
    if not sparing:
        columns.cost[:] = 0.0
    kept = np.array(VERTICAL if vertical else range(6))
    balance = np.concatenate([loads[:, :3], loads[:, 3:] / lengths[:, None]], axis=1)[:, kept].ravel() / unit
    program = _program(columns, columns.wrenches(centres_W, lengths)[:, :, kept], balance, len(points.dry))
    point = solve(program, ACCURACY, solver)
    if isinstance(point, str) or not (np.isfinite(point.x).all() and np.isfinite(point.dual).all()):
        return None
    velocity = np.zeros((len(names), 6))
    velocity[:, kept] = point.dual[: program.equal].reshape(-1, len(kept))
    speed = np.abs(velocity).max(axis=1, initial=0.0)
    fastest = float(speed.max(initial=0.0)) or 1.0
    velocity[:, 3:] /= lengths[:, None]
    pressed, along = np.maximum(point.x[: len(points.dry)], 0.0), point.x[len(points.dry) : -1]
    return StudPoint(
        inf if INFEASIBLE in point.status else float(point.x[-1]),
        names,
        velocity / fastest,
        speed / fastest,
        not (vertical or sparing),
        points,
        unit * pressed,
        unit * along.reshape(3, -1).T,
    )


@dataclass(frozen=True, slots=True)
class HalvedJoints:
    """A problem in which the points of each joint of studs are replaced by two, each with the strength of half of them.

    Its forces are those of the whole problem that are equal within both halves.
    """

    problem: Problem
    halves: Sequence[tuple[Indices, int]]  # per contact, the halves of all points, and how many each has

    @classmethod
    def of(cls, problem: Problem) -> "HalvedJoints | None":
        """Return the problem; None if no joint is of studs."""
        if not any(_is_halved(contact) for contact in problem.contacts):
            return None
        contacts, halves = [], []
        for contact in problem.contacts:
            count, law = len(contact.points_W) // 2, contact.law
            if not (isinstance(law, MohrCoulomb) and _is_halved(contact)):
                halves.append((np.arange(len(contact.points_W)), 1))
                contacts.append(contact)
                continue
            points = np.array(contact.points_W)
            order = np.argsort(points[:, np.ptp(points, axis=0).argmax()], kind="stable")
            half = np.zeros(2 * count, dtype=np.int64)
            half[order[count:]] = 1
            halves.append((half, count))
            middles: list[Vec3] = [tuple(points[half == side].mean(axis=0).tolist()) for side in (0, 1)]
            contacts.append(replace(contact, points_W=tuple(middles), law=law.times(count)))
        return cls(replace(problem, contacts=contacts), halves)

    def spread(self, forces: Forces) -> Forces:
        """Return forces of the halved problem as forces of the whole one."""
        return Forces(
            tuple(
                of_contact
                if count == 1
                else tuple(tuple(scale(1.0 / count, force) for force in of_contact[side]) for side in half.tolist())
                for of_contact, (half, count) in zip(forces.of_contacts, self.halves, strict=True)
            )
        )


def _is_halved(contact: Contact) -> bool:
    return isinstance(contact.law, MohrCoulomb) and _is_flat(contact, level=False) and len(contact.points_W) % 2 == 0


def _is_flat(contact: Contact, level: bool) -> bool:
    """Return whether the greatest friction of a contact is the same at all normal forces, and whether it is level."""
    if len(contact.normals_W) != 1 or contact.law.friction != 0.0:
        return False
    return not level or contact.normals_W[0][2] >= LEVEL


@dataclass(frozen=True, slots=True, eq=False)
class _Columns:
    """Forces and torques at unit variables, each on a pair of bricks; the last ones are the pulls of all joints."""

    on: Indices  # (columns, 2)
    at_W: Array  # (columns, 3) [m]
    forces: Array  # (columns, 3) in units of force
    torques: Array  # (columns, 3) likewise, times m
    number: Indices  # (columns,) their variables: the pulls share one
    cost: Array  # (variables,)

    @classmethod
    def of(cls, points: _Points, unit: float, *, vertical: bool) -> "_Columns":
        """Return the columns of the forces at dry points, those along joints unless `vertical`, and the pulls."""
        dry, joints = len(points.dry), len(points.pull)
        on, at_W, forces = [points.bodies[points.dry]], [points.points_W[points.dry]], [points.normals_W[points.dry]]
        cost = [np.zeros(dry)]
        torques = [np.zeros((dry + (0 if vertical else 2 * joints), 3))]
        if not vertical:
            first = points.count[:, None, None] * points.along_W[points.first]
            on, at_W = [*on, *3 * [points.on]], [*at_W, *3 * [points.middle_W]]
            forces += [first[:, 0], first[:, 1], np.zeros((joints, 3))]
            torques += [points.reach[:, None] * points.normal_W]
            usual = np.minimum(points.shear, points.pull)  # a bound that is never reached would count as no cost
            stiff = SMALL / max(joints, 1) * np.square(unit / np.maximum(usual, WEAK * unit))
            cost += [stiff / points.count, stiff / points.count, stiff]
        variables = sum(map(len, cost)) + 1
        number = np.minimum(np.arange(variables - 1 + joints), variables - 1)
        return cls(
            np.concatenate([*on, points.on]),
            np.concatenate([*at_W, points.middle_W]),
            np.concatenate([*forces, -(points.pull * points.count / unit)[:, None] * points.normal_W]),
            np.concatenate([*torques, np.zeros((joints, 3))]),
            number,
            np.concatenate([*cost, [0.0]]),
        )

    def wrenches(self, centres_W: Array, lengths: Array) -> Array:
        """Return (2, columns, 6) the wrenches on the lower and on the upper brick, torques over its length."""
        both = []
        for body, sign in zip(self.on.T, (-1.0, 1.0), strict=True):
            turning = self.torques + cross_rows(self.at_W - centres_W[body], self.forces)
            both.append(sign * np.concatenate([self.forces, turning / lengths[body][:, None]], axis=1))
        return np.stack(both)


def _program(columns: _Columns, wrenches: Array, loads: Array, pressing: int) -> ConicProgram:
    """Return the program of the least share, in which the first `pressing` variables are not negative."""
    from scipy.sparse import csc_matrix, diags  # noqa: PLC0415 -- slow to import, and most verdicts need no solver

    bodies, components = columns.on.T[:, :, None], np.arange(wrenches.shape[2])
    used = (wrenches != 0.0) & (bodies >= 0)
    variables = len(columns.cost)
    positive = np.append(np.arange(pressing), variables - 1)
    values = np.append(wrenches[used], np.full(len(positive), -1.0))
    rows = np.append((bodies * len(components) + components)[used], len(loads) + np.arange(len(positive)))
    numbers = np.append(np.broadcast_to(columns.number[None, :, None], used.shape)[used], positive)
    matrix = csc_matrix((values, (rows, numbers)), shape=(len(loads) + len(positive), variables))
    least = np.zeros(variables)
    least[-1] = 1.0
    curvature = diags(columns.cost, format="csc") if columns.cost.any() else None
    offset = np.append(-loads, np.zeros(len(positive)))
    return ConicProgram(least, matrix, offset, len(loads), (), len(positive), curvature)
