"""An assembly of bricks with its proofs: the public API of statics."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import chain
from math import ceil, floor, inf, log10
from time import perf_counter
from types import MappingProxyType
from typing import Any, Final

from stability.contact_law import GivenFriction, admit_friction
from stability.geometry.box import Box, OffCentreBox
from stability.geometry.box_distance import BESIDE, LIMIT_ITSELF, reach_between
from stability.geometry.placed_shape import apart, apart_from_plane, bounds_W
from stability.geometry.polygons import Point2, depth
from stability.geometry.spatial_grid import Neighbours
from stability.geometry.vectors import (
    LONGEST,
    SHORTEST,
    add,
    admit_in_range,
    admit_number,
    admit_numbers,
    dot,
    listed,
    short_repr,
    subtract,
)
from stability.graph import reached
from stability.joints import DRY, Joints, admit_joints
from stability.loads import UNLOADED, Loads, admit_loads
from stability.model import EARTH, GROUND, BodyId, Brick, ConvexShape, Plane, Pose, Vec3
from stability.name_order import names_text
from stability.problem import (
    Contact,
    Crushing,
    Forces,
    Placed,
    Problem,
    Stability,
    Stage,
    Tolerances,
    Verdict,
    Wrench,
    by_place,
    rounded,
)
from stability.process_settings import one_thread, rarely_collected
from stability.statics.certificate import Tally, brick_graph, force_sums, rests_on, total_forces
from stability.statics.fall_description import described
from stability.statics.journal import JournaledDict
from stability.statics.prover import Prover, ProverState
from stability.statics.structure import Structure
from stability.strength import NO_STRENGTHS, Strength, admit_strengths
from stability.ties import Tie, admit_ties

# Input checks of statics. Invalid numbers are errors with a remedy.


UNIT = 1e-6  # accepted difference of the length of a quaternion or a normal from 1
PLAIN = {float, int}  # types of numbers that need no further check
LIGHTEST, HEAVIEST = 1e-60, 1e60  # [kg]
WEAKEST, STRONGEST = 1e-60, 1e60  # [m/s2] of gravity


def admit_brick(placed: Placed) -> None:
    """Raise ValueError for an invalid size, mass or place of a brick, TypeError for anything but a brick."""
    try:
        if _is_usual(placed):
            return
    except (AttributeError, TypeError):
        pass  # reported below
    _admit_kinds(placed)
    brick, name = placed.brick, placed.brick.id
    _admit_shape("brick", name, brick.shape)
    remedy = f"write a number from {LIGHTEST:g} to {HEAVIEST:g}, in kilograms"
    admit_in_range(f"the mass of brick '{name}' is", brick.mass, LIGHTEST, HEAVIEST, remedy)
    admit_place(placed)


def _is_usual(placed: Placed) -> bool:
    """Return whether a brick is valid, by the fastest test, since every new brick passes it."""
    brick, pose = placed.brick, placed.pose
    if not isinstance(brick.shape, Box):
        return False  # the complete check follows
    size = brick.shape.size
    if not isinstance(brick, Brick) or not isinstance(pose, Pose) or not isinstance(brick.id, str):
        return False
    if not (len(size) == len(pose.position_W) == 3 and len(pose.orientation) == 4):  # noqa: PLR2004 -- as they are
        return False
    (a, b, c), (x, y, z), (i, j, k, w) = size, pose.position_W, pose.orientation
    return (
        PLAIN.issuperset(map(type, (a, b, c, x, y, z, i, j, k, w, brick.mass)))
        and type(size) is tuple
        and SHORTEST <= a <= LONGEST
        and SHORTEST <= b <= LONGEST
        and SHORTEST <= c <= LONGEST
        and LIGHTEST <= brick.mass <= HEAVIEST
        and -LONGEST <= x <= LONGEST
        and -LONGEST <= y <= LONGEST
        and -LONGEST <= z <= LONGEST
        and -UNIT <= i * i + j * j + k * k + w * w - 1.0 <= UNIT
    )


def _admit_kinds(placed: object) -> None:
    """Raise TypeError for anything but a brick in a pose."""
    if not isinstance(placed, Placed):
        raise TypeError(f"expected Placed(brick, pose), not {short_repr(placed)}")
    if not isinstance(placed.brick, Brick):
        raise TypeError(f"expected Brick(name, shape, mass), not {short_repr(placed.brick)}")
    admit_name("a brick", placed.brick.id)
    if not isinstance(placed.pose, Pose):
        raise TypeError(
            f"the pose of brick '{placed.brick.id}' is {short_repr(placed.pose)}; write Pose((x, y, z)), in metres"
        )


def admit_name(what: str, name: object) -> None:
    """Raise TypeError for anything but a name."""
    if not isinstance(name, str):
        raise TypeError(f"the name of {what} is {short_repr(name)}; write a string")


def admit_place(placed: Placed) -> None:
    """Raise ValueError for an invalid pose, TypeError for anything but a pose."""
    name, pose = placed.brick.id, placed.pose
    _admit(name, "position", pose.position_W, 3, "write x, y and z in metres")
    if not all(-LONGEST <= part <= LONGEST for part in pose.position_W):
        raise ValueError(
            f"the position of brick '{name}' is {short_repr(pose.position_W)}; "
            f"it must be within {LONGEST:g} m of the origin"
        )
    _admit(name, "orientation", pose.orientation, 4, "write a quaternion x, y, z, w")
    if abs(sum(part * part for part in pose.orientation) - 1.0) > UNIT:
        raise ValueError(
            f"the orientation of brick '{name}' is {short_repr(pose.orientation)}; write a unit quaternion"
        )


def admit_site(planes: Sequence[Plane], tables: Sequence[Placed], friction: GivenFriction, gravity: float) -> None:
    """Raise ValueError for invalid fixed bodies, friction or gravity, TypeError for other types."""
    admit_friction(friction)
    remedy = f"write a number from {WEAKEST:g} to {STRONGEST:g}, in m/s2; gravity points down"
    admit_in_range("the gravity is", gravity, WEAKEST, STRONGEST, remedy)
    for plane in planes:
        _admit_plane(plane)
    for table in tables:
        _admit_kinds(table)
        _admit_shape("table", table.brick.id, table.brick.shape)
        admit_place(table)
    names = [plane.id for plane in planes] + [table.brick.id for table in tables]
    admit_names(names, ())


def admit_forces(forces: object) -> None:
    """Raise TypeError for anything but forces of a proof; None stands for unknown forces."""
    if forces is not None and not isinstance(forces, Forces):
        raise TypeError(f"expected Forces, as returned by `assembly.forces()`, not {short_repr(forces)}")


def admit_overlap(overlap: float) -> None:
    """Raise ValueError for an invalid depth, TypeError for anything but a number."""
    admit_number("the overlap is", overlap, "write a number, in metres")
    if not overlap >= 0.0:
        raise ValueError(f"the overlap is {overlap} m; it must be at least 0")


def _admit_shape(what: str, name: BodyId, shape: ConvexShape) -> None:
    limits = f"from {SHORTEST:g} to {LONGEST:g} m"
    match shape:
        case Box(size):
            _admit_size(what, name, size)
        case tuple():
            raise ValueError(f"the shape of {what} '{name}' is {short_repr(shape)}; write Box({short_repr(shape)})")
        case OffCentreBox(size, centre):
            _admit_size(what, name, size)
            _admit(name, "centre of mass", centre, 3, "write x, y and z from the centre of the box, in metres")
            if any(abs(part) >= 0.5 * side for part, side in zip(centre, size, strict=True)) and what == "brick":
                raise ValueError(f"the centre of mass of {what} '{name}' is {centre}, outside the box of size {size}")
        case _ if not (hasattr(shape, "faces") and hasattr(shape, "least_thickness")):
            raise TypeError(
                f"the shape of {what} '{name}' is {short_repr(shape)}; write Box((length, width, thickness)), in metres"
            )
        case _ if not SHORTEST <= shape.least_thickness <= shape.length <= LONGEST:
            across = f"{shape.least_thickness} to {shape.length} m"
            raise ValueError(f"{what} '{name}' measures {across}; each dimension must be {limits}")


def _admit_size(what: str, name: BodyId, size: Sequence[float]) -> None:
    _admit(name, "size", size, 3, "write length, width and thickness, in metres")
    if not isinstance(size, tuple):
        raise TypeError(f"the size of {what} '{name}' is {short_repr(size)}; write a tuple, as in Box((0.4, 0.3, 0.2))")
    if not all(SHORTEST <= side <= LONGEST for side in size):
        limits = f"from {SHORTEST:g} to {LONGEST:g} m"
        raise ValueError(f"the size of {what} '{name}' is {short_repr(size)}; each side must be {limits}")


def _admit_plane(plane: Plane) -> None:
    if not isinstance(plane, Plane):
        raise TypeError(f"expected Plane(name, point, normal, friction), not {short_repr(plane)}")
    admit_name("a plane", plane.id)
    admit_number(f"the friction of plane '{plane.id}' is", plane.friction, "write a coefficient of at least 0")
    _admit(plane.id, "point", plane.point_W, 3, "write x, y and z in metres")
    if not all(-LONGEST <= part <= LONGEST for part in plane.point_W):
        raise ValueError(
            f"the point of plane '{plane.id}' is {short_repr(plane.point_W)}; "
            f"it must be within {LONGEST:g} m of the origin"
        )
    _admit(plane.id, "normal", plane.normal_W, 3, "write x, y and z of the outward normal")
    if abs(sum(part * part for part in plane.normal_W) - 1.0) > UNIT:
        raise ValueError(f"the normal of plane '{plane.id}' is {plane.normal_W}; write a unit vector")
    if not 0.0 <= plane.friction < float("inf"):
        raise ValueError(f"the friction of plane '{plane.id}' is {plane.friction}; it must be finite and at least 0")


def admit_names(coming: Iterable[BodyId], known: Collection[BodyId]) -> None:
    """Raise ValueError for a name that is already in use."""
    among: set[BodyId] = set()
    for name in coming:
        if name in known or name in among:
            raise ValueError(f"there are two bodies with the name '{name}'; give each a different name")
        among.add(name)


def _admit(name: BodyId, what: str, numbers: Sequence[float], count: int, remedy: str) -> None:
    admit_numbers(f"the {what} of '{name}' is", numbers, count, remedy)


# Queries about placed bricks and their proofs, without changes.


LAST: Final = "last"


class AssemblyAnswers:
    """Bricks, fixed bodies, and the proof of each brick."""

    _working: Prover
    _strengths: Mapping[BodyId, Strength]
    _ties: Sequence[Tie]
    _last_verdict: JournaledDict[str, Verdict]

    @property
    def _prover(self) -> Prover:
        """Return the proofs of all completed changes."""
        self._working.structure.journal.undo()
        return self._working

    @property
    def _structure(self) -> Structure:
        return self._prover.structure

    @property
    def _verdict(self) -> Verdict:
        self._working.structure.journal.undo()
        return self._last_verdict[LAST]

    @property
    def bricks(self) -> Mapping[BodyId, Placed]:
        """Return the bricks in the order in which they were added."""
        return MappingProxyType(self._structure.bricks)

    @property
    def planes(self) -> tuple[Plane, ...]:
        """Return the fixed planes."""
        return self._structure.planes

    @property
    def tables(self) -> tuple[Placed, ...]:
        """Return the fixed boxes."""
        return self._structure.tables

    @property
    def friction(self) -> GivenFriction:
        """Return the friction between bricks, as it was given."""
        return self._structure.friction

    @property
    def joints(self) -> Joints:
        """Return the joints that hold bodies together."""
        return self._structure.joints

    @property
    def strengths(self) -> Mapping[BodyId, Strength]:
        """Return the strengths of bricks against crushing."""
        return MappingProxyType(self._strengths)

    @property
    def loads(self) -> Loads:
        """Return the loads on bricks besides their weight."""
        return self._structure.loads

    @property
    def ties(self) -> Sequence[Tie]:
        """Return the ties, whether they hold already or not."""
        return self._ties

    @property
    def gravity(self) -> float:
        """Return the acceleration of free fall [m/s2]."""
        return self._structure.gravity

    @property
    def tolerances(self) -> Tolerances:
        """Return the tolerances of statics."""
        return self._structure.tolerances

    def _reject_unknown(self, names: Sequence[BodyId]) -> None:
        for name in names:
            admit_name("a brick", name)
            if name not in self._structure.bricks:
                present = names_text([*self._structure.bricks]) or "no brick"
                raise LookupError(f"there is no brick '{name}'; the assembly has {present}")

    def verdict(self) -> Verdict:
        """Return the last verdict, which is that of the whole assembly."""
        return self._verdict

    def stage(self, brick: BodyId) -> Stage | None:
        """Return the stage that proved a brick; None if it has no proof."""
        self._reject_unknown([brick])
        stage = self._prover.ledger.stage(brick)
        return Stage.CONES if stage is None and self._verdict.stability is Stability.STABLE else stage

    def contacts(self, brick: BodyId) -> Sequence[Contact]:
        """Return the contacts of a brick with bricks and planes."""
        self._reject_unknown([brick])
        return tuple(self._structure.contacts_of([brick]))

    def all_contacts(self) -> Sequence[Contact]:
        """Return all contacts, each once."""
        return self._structure.contacts_of(self._structure.bricks)

    def with_all_above(self, bricks: Collection[BodyId]) -> set[BodyId]:
        """Return these bricks and all bricks that they can carry, directly or through others."""
        self._reject_unknown(sorted(bricks))
        return self._structure.with_all_above(bricks)

    def with_all_below(self, bricks: Collection[BodyId]) -> set[BodyId]:
        """Return these bricks and all bricks that can carry them, directly or through others."""
        self._reject_unknown(sorted(bricks))
        return reached(bricks, lambda brick: self._structure.below([brick]))

    def around(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        """Return a superset, by bounding boxes, of the bricks within a distance [m] of a brick, by name."""
        self._reject_unknown([brick])
        return self._structure.around(brick, within)

    def core_depth(self, brick: BodyId, point: Point2) -> float:
        """Return the depth of a point in plan in a brick's load core [m]; negative outside, -inf without a core."""
        self._reject_unknown([brick])
        return depth(point, self._structure.cores[brick].polygon)

    def rests_on(self, brick: BodyId) -> tuple[BodyId, ...]:
        """Return the bodies that a brick rests on or leans on, by name."""
        self._reject_unknown([brick])
        return tuple(rests_on(self._structure, self._prover.ledger, brick))

    def problem(self, bricks: Collection[BodyId] | None = None) -> Problem:
        """Return the equilibrium problem of some bricks with all others held fixed, or that of all bricks.

        Ties whose tension the loads determine have an unknown one, up to their strength.
        """
        group = list(self._structure.bricks) if bricks is None else sorted(bricks)
        self._reject_unknown(group)
        problem = self._structure.tied_problem(group, self._structure.contacts_of(group))
        if not problem.ties:
            return problem
        from stability.statics.tied_rest import determined_tensions  # noqa: PLC0415 -- it brings numpy

        return determined_tensions(problem)

    def forces(self) -> Forces | None:
        """Return contact forces that balance all bricks, one entry per contact of `all_contacts()`; None unless STABLE.

        They are checked by arithmetic and not unique.
        """
        if not self._prover.all_proven():
            return self._tied_forces()
        from stability.statics.proof import check_forces  # noqa: PLC0415 -- it brings numpy, and verdicts do without

        problem = self.problem()
        forces = total_forces(self._structure, self._prover.ledger, list(problem.contacts))
        forces = replace(forces, more_tension=(0.0,) * len(problem.ties))
        check = check_forces(problem, forces, rounded(problem, self._structure.tolerances))
        if not check.holds:
            again = self._rebalanced(problem, forces)
            if again is None:
                raise ArithmeticError(f"the check of the proof of the assembly failed: {check}")
            return again
        return forces

    def _rebalanced(self, problem: Problem, forces: Forces) -> Forces | None:
        """Return forces near some whose residual is too large, such as a sum of many proofs that each have a little."""
        if problem.has_joints or problem.is_round or problem.ties:
            return None
        from stability.statics.equilibrium import proven_forces  # noqa: PLC0415 -- it brings numpy
        from stability.statics.wrench_matrix import flattened, wrench_matrix  # noqa: PLC0415 -- likewise

        system = wrench_matrix(problem)
        rows = system.rows_of(flattened(forces))
        return proven_forces(problem, system, rows, rounded(problem, self.tolerances))

    def _tied_forces(self) -> Forces | None:
        """Return the forces of bricks that stand by ties that are drawn tighter than they were put on."""
        if self._verdict.stability is not Stability.STABLE:
            return None
        from stability.statics.tied_rest import tied_rest  # noqa: PLC0415 -- it brings numpy

        problem = self.problem()
        return tied_rest(problem, rounded(problem, self.tolerances)).forces

    def forces_above(self, bricks: Collection[BodyId], among: Set[BodyId] | None = None) -> Tally:
        """Return the forces of the proof on these bricks and on all that they carry, by contact.

        Such forces are not unique, and these are not checked. With `among` load cores carry the weights of these bricks
        only.
        """
        weighed = self.with_all_above(bricks) if among is None else among
        return force_sums(self._structure, self._prover.ledger, weighed)

    def shares(self, brick: BodyId) -> Mapping[BodyId, float]:
        """Return the supports of a brick with their shares of its load; `brick_graph` defines them."""
        self._reject_unknown([brick])
        return self.all_shares(self._structure.with_all_above([brick]))[brick]

    def all_shares(self, bricks: Collection[BodyId] | None = None) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """Return the shares of all bricks, or of some bricks as if no others were present."""
        return brick_graph(self._structure, self._prover.ledger, self._structure.bricks if bricks is None else bricks)


# Refuses bricks that overlap other bricks or fixed bodies: statics would take them as separate.


# [m] Accepted overlap: rounding in files, far below manufacturing tolerances. It is smaller for bodies so thin that
# they would no longer touch.
OVERLAP = 1e-4
MILLIMETRES = 1000.0


def refuse_overlaps(structure: Structure, coming: Sequence[Placed], overlap: float, leaving: BodyId = "") -> None:
    """Raise ValueError for the first new brick that overlaps a present or new body by more than `overlap` [m].

    `leaving` is a present brick that is about to be removed.
    """
    if not leaving and structure.are_clear(coming, overlap):
        return
    among: Neighbours[BodyId] = Neighbours()
    new: dict[BodyId, Placed] = {}
    for placed in coming:
        low_W, high_W = bounds_W(placed.brick.shape, placed.pose)
        for plane in structure.planes:
            if _is_above(plane, low_W, high_W):
                continue
            gap = apart_from_plane(placed.brick.shape, placed.pose, plane).gap
            _refuse(placed, plane.id, gap, min(overlap, reach_between(placed.brick.shape.least_thickness)))
        inside = _shrunk(low_W, high_W, min(overlap, reach_between(placed.brick.shape.least_thickness)))
        others = structure.within(*inside)
        for other in (*others, *(new[name] for name in among.around(*inside, 0.0))):
            if other.brick.id != leaving:
                forgiven = reach_between(placed.brick.shape.least_thickness, other.brick.shape.least_thickness)
                gap = apart(placed.brick.shape, placed.pose, other.brick.shape, other.pose).gap
                _refuse(placed, other.brick.id, gap, min(overlap, forgiven))
        among.add(placed.brick.id, low_W, high_W)
        new[placed.brick.id] = placed


def _is_above(plane: Plane, low_W: Vec3, high_W: Vec3) -> bool:
    """Return whether a box in space is outside a plane."""
    nearest = sum(
        part * (low if part > 0.0 else high) for part, low, high in zip(plane.normal_W, low_W, high_W, strict=True)
    )
    return nearest >= dot(plane.normal_W, plane.point_W)


def _shrunk(low_W: Vec3, high_W: Vec3, by: float) -> tuple[Vec3, Vec3]:
    """Return a smaller box; a body outside it overlaps the brick by less than `by` along some axis."""
    a, b, c = (min(by, 0.25 * side) for side in subtract(high_W, low_W))
    return add(low_W, (a, b, c)), subtract(high_W, (a, b, c))


def _refuse(placed: Placed, other: BodyId, gap: float, forgiven: float) -> None:
    if -gap > LIMIT_ITSELF * forgiven:
        depth = f"{MILLIMETRES * -gap:.3g} mm inside '{other}'"
        raise ValueError(
            f"brick '{placed.brick.id}' is {depth}; move it, or create the Assembly with a larger `overlap`"
        )


# Placed bricks and their proofs: the statics API.
#
#     >>> assembly = Assembly()
#     >>> plank = Brick("a", Box((0.12, 0.024, 0.008)), 0.0115)
#     >>> assembly.add(plank, Pose((0.0, 0.0, 0.004))).stability
#     <Stability.STABLE: 'stable'>
#
# No engine is involved. Bricks are added, removed and moved one by one or together, and only the affected part is
# judged again. Each change takes effect completely or not at all: an interrupted change leaves no trace.


BREAKS = (
    "brittle joints may break: they reach their strength in an elastic calculation, and without them it is not "
    "proven to stand"
)

STRENGTH_NOT_JUDGED = "strengths of bricks are not judged with joints or round contacts"
STRENGTH_IN_DOUBT = "it is proven neither that the bricks bear their loads nor that one crushes"

DIGITS = 3  # of the least width of gaps that a verdict depends on, rounded up
NOISE = 1e-9  # share of a width that is rounding: it does not turn 1 mm into 1.01 mm

LEVEL_GROUND = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction=0.5)


@dataclass(frozen=True, slots=True)
class AssemblyState:
    """Snapshot of all bricks of an assembly and their proofs, made by `state`."""

    of: "Assembly"
    known: ProverState
    verdict: Verdict


@dataclass(slots=True)
class CountedGaps:
    """The least width of gaps that must count as contact for bricks to be STABLE, computed on demand and cached.

    Measured or wooden bricks have gaps of some hundredths of a millimetre, and settle: so gaps count as contact. A
    verdict that depends on these gaps says so.
    """

    bricks: Sequence[Placed]
    contacts: Sequence[Contact]  # with gaps
    planes: tuple[Plane, ...]
    friction: GivenFriction
    gravity: float  # [m/s2]
    tolerances: Tolerances
    tables: tuple[Placed, ...]
    joints: Joints
    loads: Loads
    ties: Sequence[Tie] = ()
    _answer: float | None = field(default=None, init=False)

    def within(self) -> float:
        """Return the least `Tolerances.within` [m] with which the bricks are proven stable, rounded up to 3 digits."""
        if self._answer is None:
            self._answer = self._searched()
            self.bricks, self.contacts = (), ()
        return self._answer

    def _searched(self) -> float:
        if self._is_stable(0.0):
            return 0.0
        widths = sorted({_rounded_up(width) for contact in self.contacts for width in _widths(contact)})
        below, enough = -1, len(widths)
        while enough - below > 1:
            middle = (below + enough) // 2
            if self._is_stable(widths[middle]):
                enough = middle
            else:
                below = middle
        return widths[min(enough, len(widths) - 1)]

    def _is_stable(self, within: float) -> bool:
        tolerances = replace(self.tolerances, within=min(within, self.tolerances.within))
        site = self.planes, self.friction, self.gravity, tolerances, self.tables
        assembly = Assembly(*site, overlap=inf, joints=self.joints, loads=self.loads, ties=self.ties)
        return assembly.add_all(self.bricks, names_smallest=False).stability is Stability.STABLE


def _widths(contact: Contact) -> Iterable[float]:
    """Yield by point the least `Tolerances.within` [m] with which its gap counts; see `gap_bridged`."""
    share = min(1.0, max(BESIDE, *(abs(normal[2]) for normal in contact.normals_W)))
    return (gap / share for gap in contact.gaps if gap > 0.0)


def _rounded_up(width: float) -> float:
    unit = 10.0 ** (floor(log10(width)) - DIGITS + 1)
    return float(f"{ceil(width / unit * (1.0 - NOISE)) * unit:.{DIGITS}g}")


class Assembly(AssemblyAnswers):
    """Bricks, fixed bodies, and the proof of each brick."""

    def __init__(  # noqa: PLR0913 -- all that a site is made of
        self,
        planes: Iterable[Plane] = (LEVEL_GROUND,),
        friction: GivenFriction = 0.5,
        gravity: float = EARTH,
        tolerances: Tolerances = Tolerances(),  # noqa: B008 -- frozen
        tables: Iterable[Placed] = (),
        *,
        overlap: float = OVERLAP,
        joints: Joints = DRY,
        loads: Loads = UNLOADED,
        strengths: Mapping[BodyId, Strength] = NO_STRENGTHS,
        ties: Sequence[Tie] = (),
    ) -> None:
        """Start with the fixed bodies: planes, and `tables`, which are boxes that never move.

        `friction` is the Coulomb coefficient between bricks and on tables, or a `Friction` if it differs by brick or by
        pair; `gravity` is along -z [m/s2]. A new brick that overlaps another body by more than `overlap` [m], or by so
        much that the two would not count as touching, is a ValueError; with `inf` no overlap is. `joints` hold bodies
        together; their verdicts are those of limit analysis, in which a joint that yields keeps its force. `loads` act
        on their bricks from the placement on. `strengths` against crushing are by brick: a structure that no forces
        within them balance is UNSTABLE, with the brick that crushes. `ties` pull their bricks as soon as all of them
        are placed, and come off when one of them is removed or moved.
        """
        planes, tables = listed(planes, "planes, such as [Plane(...)]"), listed(tables, "tables, such as [Placed(...)]")
        admit_site(planes, tables, friction, gravity)
        admit_overlap(overlap)
        admit_joints(joints)
        admit_loads(loads)
        admit_strengths(strengths)
        admit_ties(ties)
        if not isinstance(tolerances, Tolerances):
            raise TypeError(f"expected Tolerances(...), not {short_repr(tolerances)}")
        self._overlap = overlap
        self._strengths, self._ties = dict(strengths), tuple(ties)
        self._fixed = {plane.id for plane in planes} | {table.brick.id for table in tables}
        self._working = Prover(Structure(planes, tables, friction, gravity, tolerances, joints, loads))
        self._last_verdict: JournaledDict[str, Verdict] = JournaledDict(
            self._working.structure.journal
        )  # the last verdict
        self._last_verdict[LAST] = Verdict(Stability.STABLE)
        self._working.structure.journal.keep()

    def copied(self) -> "Assembly":
        """Return an independent copy with the same bricks and proofs; `copy` and `pickle` make such copies too."""
        make, arguments = self.__reduce__()
        return make(*arguments)

    def with_joints(self, joints: Joints) -> "Assembly":
        """Return an assembly of the same bricks with other joints, judged again."""
        return self._again(joints, self.loads)

    def with_loads(self, loads: Loads) -> "Assembly":
        """Return an assembly of the same bricks under other loads, judged again."""
        return self._again(self.joints, loads)

    def _again(self, joints: Joints, loads: Loads) -> "Assembly":
        structure = self._structure
        site = self.planes, self.friction, self.gravity, structure.tolerances, self.tables
        ties = [tie for tie in self._ties if structure.ties.get(tie.name, tie) is not None]
        again = Assembly(*site, overlap=inf, joints=joints, loads=loads, strengths=self._strengths, ties=ties)
        again.add_all(self.bricks.values(), names_smallest=len(self.bricks) <= MOST)
        again._overlap = self._overlap
        return again

    def __copy__(self) -> "Assembly":
        """Return a copy as `copied` does: assemblies change no stored object in place, so copies may share them."""
        return self.copied()

    def __deepcopy__(self, memo: dict[int, object]) -> "Assembly":
        """Return a copy as `copied` does."""
        return self.copied()

    def __reduce__(self) -> "tuple[Callable[..., Assembly], tuple[object, ...]]":
        """Return the fixed bodies and the state for pickle."""
        structure = self._structure
        fixed = self.planes, self.friction, self.gravity, structure.tolerances, self.tables
        site = *fixed, self._overlap, self.joints, self.loads, self._strengths, self._ties
        return _made_again, (type(self), site, self._prover.state(), self._verdict)

    # --- changes ------------------------------------------------------------------------------------------------------

    def hold_by(self, joints: Joints) -> None:
        """Replace the joints, for the contacts of bricks that are set down from now on."""
        admit_joints(joints)
        self._structure.joints = joints

    def add(self, brick: Brick, pose: Pose) -> Verdict:
        """Set down one brick at rest and return the verdict on all bricks. Raises ValueError for an invalid brick."""
        return self._set_down((Placed(brick, pose),), names_smallest=True)

    def add_all(self, bricks: Iterable[Placed], *, names_smallest: bool = True) -> Verdict:
        """Set down bricks together, at rest. Raises ValueError, before any change, for an invalid brick.

        With `names_smallest` an UNSTABLE verdict names the smallest set found that falls without the rest; this takes
        seconds for a heap.
        """
        return self._set_down(listed(bricks, "bricks, such as [Placed(brick, pose)]"), names_smallest)

    def would(self, brick: Brick, pose: Pose) -> Verdict:
        """Return the verdict of `add` without a change."""
        return self._set_down((Placed(brick, pose),), names_smallest=True, keep=False)

    def would_all(self, bricks: Iterable[Placed], *, names_smallest: bool = True) -> Verdict:
        """Return the verdict of `add_all` without a change."""
        return self._set_down(listed(bricks, "bricks, such as [Placed(brick, pose)]"), names_smallest, keep=False)

    def would_without(self, bricks: Collection[BodyId], *, names_smallest: bool = True) -> Verdict:
        """Return the verdict of `remove` without a change."""
        return self._removed(bricks, names_smallest, keep=False)

    @contextmanager
    def _changing(self) -> Iterator[Prover]:
        """Make a change that takes effect only when the journal keeps it.

        If an interrupt stops the undoing of an interrupted change, the next call continues it.
        """
        working = self._prover
        try:
            yield working
        finally:
            working.structure.journal.undo()

    def state(self) -> AssemblyState:
        """Return all placed bricks with their proofs, which `restore` accepts any number of times."""
        return AssemblyState(self, self._prover.state(), self._verdict)

    def restore(self, state: AssemblyState) -> None:
        """Restore a state, with its proofs, bit for bit. Raises ValueError for the state of another assembly."""
        if not isinstance(state, AssemblyState):
            raise TypeError(f"expected an AssemblyState, as returned by `state()`, not {short_repr(state)}")
        if state.of is not self:
            raise ValueError("this is the state of another assembly; restore it in that assembly")
        with self._changing() as prover:
            prover.restore(state.known)
            self._last_verdict[LAST] = state.verdict
            prover.structure.journal.keep()

    @one_thread()
    @rarely_collected()
    def _set_down(self, bricks: Sequence[Placed], names_smallest: bool, keep: bool = True) -> Verdict:
        started = perf_counter()
        for placed in bricks:
            admit_brick(placed)
        with self._changing() as prover:
            admit_names([placed.brick.id for placed in bricks], prover.structure.bricks)
            admit_names([placed.brick.id for placed in bricks], self._fixed)
            if self._overlap < inf:
                refuse_overlaps(prover.structure, bricks, self._overlap)
            coming = self._with_tied(prover, bricks) if self._ties else bricks
            coming = sorted(coming, key=by_place) if len(coming) > 1 else coming
            prover.put(coming)
            return self._judged(prover, started, [placed.brick.id for placed in coming], names_smallest, keep)

    def _with_tied(self, prover: Prover, coming: Sequence[Placed]) -> Sequence[Placed]:
        """Put on the ties that coming bricks complete; return these bricks with all others that the ties pull."""
        structure = prover.structure
        there = structure.bricks.keys() | {placed.brick.id for placed in coming}
        ties = [tie for tie in self._ties if tie.name not in structure.ties and tie.around <= there]
        return [*coming, *self._taken_for(prover, ties, {tie.name: tie for tie in ties})]

    def _loosened(self, prover: Prover, leaving: Collection[BodyId]) -> Sequence[Placed]:
        """Take off the ties of bricks that leave; return all other bricks that these ties pulled."""
        ties = [tie for tie in prover.structure.ties.values() if tie is not None and not tie.around.isdisjoint(leaving)]
        return self._taken_for(prover, ties, dict.fromkeys(tie.name for tie in ties))

    @staticmethod
    def _taken_for(prover: Prover, ties: Sequence[Tie], now: Mapping[str, Tie | None]) -> Sequence[Placed]:
        """Take out the present bricks that ties pull, with all above them, and put on or take off these ties."""
        structure = prover.structure
        pulled = {pull.brick for tie in ties for pull in tie.pulls} & structure.bricks.keys()
        bricks = structure.with_all_above(pulled)
        taken = [structure.bricks[name] for name in sorted(bricks)]
        if taken:
            prover.take(sorted(bricks))
        structure.ties |= now
        return taken

    def remove(self, bricks: Collection[BodyId], *, names_smallest: bool = True) -> Verdict:
        """Remove bricks. Bricks that they carried, or held by their weight, are judged again; see `add_all`."""
        return self._removed(bricks, names_smallest)

    @one_thread()
    @rarely_collected()
    def _removed(self, bricks: Collection[BodyId], names_smallest: bool, keep: bool = True) -> Verdict:
        started = perf_counter()
        if isinstance(bricks, str):
            raise TypeError(f"expected a collection of names, such as ['{bricks}'], not a string")
        names = listed(bricks, "names, such as ['a']")
        self._reject_unknown(names)
        with self._changing() as prover:
            loosened = self._loosened(prover, names) if self._ties else ()
            loosened = [placed for placed in loosened if placed.brick.id not in names]
            leaving = [name for name in sorted(set(names)) if name in prover.structure.bricks]
            again = prover.take(leaving) if leaving else []
            prover.put(sorted(loosened, key=by_place))
            changed = [*again, *(placed.brick.id for placed in loosened)]
            return self._judged(prover, started, changed, names_smallest, keep)

    @one_thread()
    def move(self, brick: BodyId, pose: Pose) -> Verdict:
        """Move a brick to another place, at rest. Raises LookupError for an unknown brick, and ValueError as `add`."""
        started = perf_counter()
        self._reject_unknown([brick])
        with self._changing() as prover:
            placed = Placed(prover.structure.bricks[brick].brick, pose)
            admit_brick(placed)
            if self._overlap < inf:
                refuse_overlaps(prover.structure, [placed], self._overlap, leaving=brick)
            loosened = [each for each in self._loosened(prover, [brick]) if each.brick.id != brick]
            again = prover.take([brick]) if brick in prover.structure.bricks else []
            prover.put(sorted([placed, *loosened], key=by_place))
            changed = [*again, *(each.brick.id for each in loosened), brick]
            return self._judged(prover, started, changed, names_smallest=True)

    def _judged(
        self, prover: Prover, started: float, changed: Sequence[BodyId], names_smallest: bool, keep: bool = True
    ) -> Verdict:
        """Prove the unproven bricks as far as possible, and commit the change if requested."""
        verdict = None if prover.all_proven() else prover.prove(names_smallest)
        if verdict is not None and any(tie is not None and tie.is_ranged for tie in prover.structure.ties.values()):
            verdict = self._judged_ties(verdict, prover.structure, names_smallest)
        if verdict is None:
            verdict = Verdict(
                Stability.STABLE, prover.costliest_stage(changed), gaps=self._gap_question(prover.structure)
            )
            if prover.structure.joints.are_brittle:  # `self.joints` would undo the change
                verdict = self._judged_brittle(verdict, prover.structure)
            if self._strengths and verdict.stability is Stability.STABLE:
                verdict = self._judged_strength(verdict, prover)
        verdict_now = self._last_verdict[LAST] = replace(verdict, seconds=perf_counter() - started)
        if keep:
            prover.structure.journal.keep()
        return verdict_now

    def _judged_ties(self, loose: Verdict, structure: Structure, names_smallest: bool) -> Verdict:
        """Return the verdict on bricks that are not proven to stand by the tension with which ties were put on."""
        from stability.statics.tied_rest import tied_rest, ties_that_yield  # noqa: PLC0415 -- it brings scipy

        bricks = list(structure.bricks)
        problem = structure.tied_problem(bricks, structure.contacts_of(bricks))
        rest = tied_rest(problem, rounded(problem, structure.tolerances), names_smallest=names_smallest)
        if rest.motion is not None:
            reason = "; ".join([described(problem, rest.motion), *ties_that_yield(problem, rest.motion)])
            moving = tuple(sorted(rest.motion.velocity))
            return Verdict(Stability.UNSTABLE, Stage.CONES, reason, moving, rest.motion)
        if rest.note:
            return Verdict(Stability.UNDECIDED, Stage.CONES, rest.note, tuple(sorted(bricks)))
        return Verdict(Stability.STABLE, Stage.CONES, gaps=self._gap_question(structure))

    def _judged_brittle(self, ductile: Verdict, structure: Structure) -> Verdict:
        """Return the verdict on bricks that stand if all joints keep their force when they yield."""
        from stability.statics.elastic_joints import elastic_factor  # noqa: PLC0415 -- it brings scipy

        bricks = list(structure.bricks)
        problem = structure.problem(bricks, structure.contacts_of(bricks))
        if not problem.is_brittle or elastic_factor(problem) >= 1.0:
            return ductile
        site = structure.planes, structure.friction, structure.gravity, structure.tolerances, structure.tables
        joints = structure.joints.without_brittle()
        without = Assembly(*site, overlap=inf, joints=joints, loads=structure.loads, ties=self._ties)
        if without.add_all(structure.bricks.values(), names_smallest=False).stability is Stability.STABLE:
            return ductile
        return Verdict(Stability.UNDECIDED, ductile.stage, BREAKS, tuple(_around_brittle(problem, structure)))

    def _judged_strength(self, rigid: Verdict, prover: Prover) -> Verdict:
        """Return the verdict on bricks of limited strength that would stand if all were rigid."""
        from stability.statics.used_strength import bear, used_strength  # noqa: PLC0415 -- it brings scipy

        structure = prover.structure
        strengths = {name: each for name, each in self._strengths.items() if name in structure.bricks}
        if not strengths:
            return rigid
        bricks = list(structure.bricks)
        problem = structure.problem(bricks, structure.contacts_of(bricks))
        if problem.has_joints or problem.is_round:
            return Verdict(Stability.UNDECIDED, rigid.stage, STRENGTH_NOT_JUDGED, tuple(sorted(strengths)))
        if not problem.ties:
            known = total_forces(structure, prover.ledger, list(problem.contacts))
            if bear(problem, known, strengths, structure.tolerances):
                return rigid
        used = used_strength(problem, strengths, structure.tolerances, decide=True)
        if used.bears:
            return rigid
        if not used.crushes:
            above = structure.with_all_above(strengths)
            return Verdict(Stability.UNDECIDED, Stage.CONES, STRENGTH_IN_DOUBT, tuple(sorted(above)))
        crushing = Crushing(used.brick, used.least)
        above = structure.with_all_above([used.brick])
        return Verdict(Stability.UNSTABLE, Stage.CONES, crushing.text, tuple(sorted(above)), crushing=crushing)

    def _gap_question(self, structure: Structure) -> tuple[CountedGaps, ...]:
        """Return the question whether the proof of all bricks depends on gaps as contact; none without gaps."""
        across = tuple(chain(*structure.across_gaps.values()))
        if not across:
            return ()
        bricks, site = tuple(structure.bricks.values()), (structure.planes, structure.friction, structure.gravity)
        tolerances, tables, joints = structure.tolerances, structure.tables, structure.joints
        return (CountedGaps(bricks, across, *site, tolerances, tables, joints, structure.loads, self._ties),)


def _around_brittle(problem: Problem, structure: Structure) -> list[BodyId]:
    """Return the bricks that brittle joints hold, and all bricks that touch these directly or through others."""
    brittle = [contact for contact in problem.contacts if contact.brittle is not None]
    held = {body for contact in brittle for body in (contact.lower, contact.upper) if body in problem.bricks}
    return sorted(held.union(*(structure.component(name) for name in held)))


def _made_again(kind: type[Assembly], site: tuple[Any, ...], known: ProverState, verdict: Verdict) -> Assembly:
    *others, overlap, joints, loads, strengths, ties = site
    made = kind(*others, overlap=overlap, joints=joints, loads=loads, strengths=strengths, ties=ties)
    made.restore(AssemblyState(made, known, verdict))
    return made


# Decides whether a standing structure also stands under additional loads.


MOST = 60  # bricks of one program: a few milliseconds


def withstands(assembly: Assembly, loads: Mapping[BodyId, Wrench]) -> bool:
    """Return whether forces are proven to balance all bricks connected with the loaded ones; False if undecided.

    Loads act at the centres of the bricks, in W. If there are too many bricks, those far from the loads are held fixed.
    """
    from stability.statics.equilibrium import balance  # noqa: PLC0415 -- it brings numpy, which standing bricks do not need

    group = _connected(assembly, sorted(loads))
    problem = assembly.problem(group)
    together = {
        brick: Wrench(add(own.force_W, loads[brick].force_W), add(own.torque_W, loads[brick].torque_W))
        if brick in loads
        else own
        for brick, own in problem.loads.items()
    }
    return balance(replace(problem, loads=together)).forces is not None


def _connected(assembly: Assembly, bricks: list[BodyId]) -> set[BodyId]:
    """Return the bricks that touch these bricks, directly or through others, or only the nearest ones."""

    def onwards(brick: BodyId) -> list[BodyId]:
        bodies = {body for contact in assembly.contacts(brick) for body in (contact.lower, contact.upper)}
        return sorted(body for body in bodies if body in assembly.bricks)

    group = set(bricks)
    front = group
    while front and len(group) < MOST:
        front = {other for brick in front for other in onwards(brick)} - group
        group |= front
    return group
