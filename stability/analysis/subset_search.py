"""Searches subsets of a design that stand: orders of removal, least sets of bricks, and props."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from math import ceil
from typing import TypeAlias

from stability.contact_law import Coulomb, as_friction
from stability.contacts.detection import seams
from stability.geometry.placed_shape import corners_W, top_W
from stability.geometry.polygons import cut, doubled_area
from stability.geometry.vectors import add, add_scaled, cross, dot, norm, rotate, scale, subtract, unit
from stability.model import BodyId, Vec3
from stability.problem import ZERO, Contact, Motion, Placed, Stability, Tolerances, rounded
from stability.statics.assembly import Assembly

# The smallest set of bricks that satisfies every clause: a clause requires one of some bricks in the set, or one of
# others outside.
#
# It is found by an integer program (HiGHS, through scipy). Its lower bound is only as good as the finished search.


MOST_NODES = 2_000  # of the search: seconds
TIE = 1e-6  # preference of an earlier brick over a later one, so that the result is unique
SLACK = 1e-3  # of the objective, more than all tie weights together


@dataclass(frozen=True, slots=True)
class Clause:
    """Condition on a set: it has a brick of `present` or lacks a brick of `absent`."""

    present: int  # bits
    absent: int = 0

    def is_satisfied_by(self, chosen: int) -> bool:
        """Return whether a set of bricks satisfies the clause."""
        return bool(chosen & self.present or self.absent & ~chosen)


@dataclass(frozen=True, slots=True)
class SmallestSet:
    """Set that satisfies all clauses; `None` if there is none."""

    chosen: int | None
    at_least: int  # lower bound on the bricks of such a set, proven by the search


def smallest(bits: int, clauses: Sequence[Clause], most_nodes: int = MOST_NODES) -> SmallestSet:
    """Return the smallest set among `bits` bricks that satisfies all clauses."""
    import numpy as np  # noqa: PLC0415 -- they take longer to load than most verdicts to find
    from scipy.optimize import Bounds, LinearConstraint, milp  # noqa: PLC0415 -- likewise
    from scipy.sparse import csr_matrix  # noqa: PLC0415 -- likewise

    if not clauses:
        return SmallestSet(0, 0)
    rows, columns, values, least = [], [], [], []
    for row, clause in enumerate(clauses):
        for bit in range(bits):
            sign = (clause.present >> bit & 1) - (clause.absent >> bit & 1)
            if sign:
                rows.append(row)
                columns.append(bit)
                values.append(float(sign))
        least.append(1.0 - clause.absent.bit_count())
    matrix = csr_matrix((values, (rows, columns)), shape=(len(clauses), bits))
    tie = min(TIE, 0.1 * SLACK / max(1, bits * bits))
    result = milp(
        1.0 + tie * np.arange(bits),
        constraints=LinearConstraint(matrix, np.array(least), np.inf),
        integrality=np.ones(bits),
        bounds=Bounds(0.0, 1.0),
        options={"node_limit": most_nodes, "mip_rel_gap": 0.0},
    )
    bound = result.mip_dual_bound
    at_least = max(0, ceil(bound - SLACK)) if bound is not None and np.isfinite(bound) else 0
    if result.x is None:
        return SmallestSet(None, at_least)
    chosen = sum(1 << bit for bit in range(bits) if result.x[bit] > 0.5)  # noqa: PLR2004 -- either 0 or 1
    return SmallestSet(chosen if all(clause.is_satisfied_by(chosen) for clause in clauses) else None, at_least)


# A contact resists a motion that does not open it fast enough.


VIOLATION = Tolerances().violation  # share of the speed there, as in the check of every proof


def resists(contact: Contact, motion: Motion, bricks: Mapping[BodyId, Placed]) -> bool:
    """Return whether forces of a contact could take power from a motion; bodies not named by it are at rest.

    A joint takes power from any motion that opens or shears it.
    """
    for point in contact.points_W:
        upper, lower = (_velocity(body, point, motion, bricks) for body in (contact.upper, contact.lower))
        slip = subtract(upper, lower)
        slack = VIOLATION * (norm(upper) + norm(lower))
        for normal in contact.normals_W:
            opening = dot(slip, normal)
            sliding = norm(subtract(slip, scale(opening, normal)))
            if contact.law.shortfall(opening, sliding) > slack:
                return True
            if not contact.law.is_cone and contact.law.support(opening, sliding, 0.0) > 0.0:
                return True
    return False


def _velocity(body: BodyId, point: Vec3, motion: Motion, bricks: Mapping[BodyId, Placed]) -> Vec3:
    if body not in motion.velocity:
        return ZERO
    velocity, spin = motion.velocity[body]
    return add(velocity, cross(spin, subtract(point, bricks[body].pose.position_W)))


# Props: fixed supports that press from below against the free part of a brick's underside, with the friction of bricks.
#
# A prop never gives way, and it stands where no brick of the finished design lies. It cannot pull. The free part of a
# face need not be convex; overlapping convex pieces cover it.


DOWNWARD = -0.05  # largest vertical part of the normal of a face that a prop can support; above it the face is a wall
LEAST_PIECE = 1e-3  # share of a face: a smaller free piece holds no prop
MOST_PIECES = 12  # per face, the largest first
PARALLEL = 1.0 - 1e-6  # cosine: a patch with such a normal lies on the face

Flat = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Prop:
    """Possible props of a brick."""

    brick: BodyId
    contacts: tuple[Contact, ...]  # with a fixed body; `upper` is the brick


def props_of(design: Assembly) -> dict[BodyId, Prop]:
    """Return the prop of each brick of a design whose underside is not completely covered."""
    props, law = {}, as_friction(design.friction)
    for name in sorted(design.bricks):
        body = f"prop under {name}"
        while body in design.bricks:
            body += "'"
        contacts = tuple(
            Contact(body, name, piece, (scale(-1.0, normal),), Coulomb(law.of(name, body)))
            for normal, piece in _free(design, name)
        )
        if contacts:
            props[name] = Prop(name, contacts)
    return props


def _free(design: Assembly, name: BodyId) -> Iterator[tuple[Vec3, tuple[Vec3, ...]]]:
    """Yield normals and corners of convex pieces that cover the free underside of a brick [in W, m]."""
    placed = design.bricks[name]
    corners = corners_W(placed.brick.shape, placed.pose)
    for face in placed.brick.shape.faces:
        normal = rotate(placed.pose.orientation, face.normal)
        if normal[2] > DOWNWARD:
            continue
        border = [corners[index] for index in face.corners]
        origin = border[0]
        along = unit(subtract(border[1], origin))
        across = cross(normal, along)

        def flat(point: Vec3, origin: Vec3 = origin, along: Vec3 = along, across: Vec3 = across) -> Flat:
            away = subtract(point, origin)
            return dot(away, along), dot(away, across)

        whole = [flat(point) for point in border]
        least = LEAST_PIECE * doubled_area(whole)[0]
        pieces = [whole]
        for patch in chain(_covering(design, name, normal), seams(placed)):
            pieces = _beside([flat(point) for point in patch], pieces, least)
        for piece in pieces:
            yield normal, tuple(add_scaled(add_scaled(origin, x, along), y, across) for x, y in piece)


def _covering(design: Assembly, name: BodyId, normal: Vec3) -> Iterator[Sequence[Vec3]]:
    """Yield the contact patches on a face of a brick, by its normal; bricks on top of a flat one cover no underside."""
    for contact in design.contacts(name):
        outward = 1.0 if contact.lower == name else -1.0
        on_it = any(outward * dot(n, normal) > PARALLEL for n in contact.normals_W)
        if on_it and contact.law.is_cone and len(contact.points_W) > 2:  # noqa: PLR2004 -- a patch has an area
            yield contact.points_W


def _beside(patch: Sequence[Flat], pieces: Sequence[Sequence[Flat]], least: float) -> list[list[Flat]]:
    """Return convex pieces that cover the parts of `pieces` outside a patch, the largest first, without empty ones."""
    if doubled_area(patch)[0] < 0.0:
        patch = patch[::-1]
    covering = []
    for piece in pieces:
        for (ax, ay), (bx, by) in zip(patch, [*patch[1:], patch[0]], strict=True):
            outside = [(by - ay) * (x - ax) - (bx - ax) * (y - ay) for x, y in piece]
            kept = cut(piece, outside)
            if len(kept) > 2 and doubled_area(kept)[0] > least:  # noqa: PLR2004 -- a polygon has three
                covering.append(kept)
    return sorted(covering, key=lambda each: -doubled_area(each)[0])[:MOST_PIECES]


# Verdicts on subsets of a design, cached. Each proven fall excludes further subsets.
#
# A motion that no contact resists proves a fall of every part that has the moving bricks and no brick that would resist
# it: only moving bricks enter its power, and bricks that are at rest and do not resist do not matter. So one proof
# covers all these parts. No such rule exists for parts that stand: a removed brick may have been a counterweight.
#
# A part is a set of bits, one per brick, in the order of names.


Part: TypeAlias = int

KEPT = 32  # cached assemblies of parts


@dataclass(frozen=True, slots=True)
class SubsetFall:
    """Proven fall, and the other parts for which the same proof holds."""

    moving: Part  # bricks that must be present
    absent: Part  # bricks that must be absent: they would resist, even at rest
    resisting: Part  # bricks whose props could resist the fall

    def covers(self, part: Part, propped: Part) -> bool:
        """Return whether the fall proves that a part falls with props under `propped`."""
        return part & self.moving == self.moving and not part & self.absent and not propped & self.resisting


@dataclass(frozen=True, slots=True)
class SubsetAnswer:
    """Verdict on a part."""

    stability: Stability
    fall: SubsetFall | None = None  # only for an UNSTABLE verdict


class Subsets:
    """Design and the verdicts on its parts."""

    def __init__(self, design: Assembly, props: Mapping[BodyId, Prop] | None = None) -> None:
        """Start without verdicts. `props` are allowed; each is used only for bricks in `propped`."""
        self.design = design
        self.names = sorted(design.bricks)
        self.whole: Part = (1 << len(self.names)) - 1
        self.props = props or {}
        self.propped: Part = 0
        self.verdict_count = 0  # number of computed verdicts
        self.falls: list[SubsetFall] = []
        self._bit = {name: 1 << index for index, name in enumerate(self.names)}
        self._answers: dict[tuple[Part, Part], SubsetAnswer] = {}
        self._assemblies: dict[Part, Assembly] = {}
        self._touching = {name: self._neighbours(name) for name in self.names}

    def _neighbours(self, name: BodyId) -> Part:
        others = {body for contact in self.design.contacts(name) for body in (contact.lower, contact.upper)}
        return self.part_of(others - {name})

    def part_of(self, bricks: Iterable[BodyId]) -> Part:
        """Return the part that consists of some bricks; other names are ignored."""
        part = 0
        for name in bricks:
            part |= self._bit.get(name, 0)
        return part

    def names_of(self, part: Part) -> list[BodyId]:
        """Return the bricks of a part, by name."""
        return [name for name in self.names if self._bit[name] & part]

    def touching(self, part: Part) -> Part:
        """Return all bricks that touch a brick of a part."""
        touching = 0
        for name in self.names_of(part):
            touching |= self._touching[name]
        return touching

    def components(self, part: Part) -> list[Part]:
        """Return the pieces of a part without contact to each other."""
        pieces = []
        while part:
            piece, front = 0, part & -part
            while front:
                piece |= front
                front = self.touching(front) & part & ~piece
            pieces.append(piece)
            part &= ~piece
        return pieces

    def ask(self, part: Part, larger: Part | None = None) -> SubsetAnswer:
        """Return whether a part stands, with its propped bricks on their props.

        `larger` is a recently judged part with a few more bricks, which makes the verdict cheaper.
        """
        propped = self.propped & part
        answer = self._answers.get((part, propped))
        if answer is None:
            fall = next((fall for fall in self.falls if fall.covers(part, propped)), None)
            answer = SubsetAnswer(Stability.UNSTABLE, fall) if fall is not None else self._judged(part, propped, larger)
            self._answers[part, propped] = answer
        return answer

    def assembly(self, part: Part, larger: Part | None = None) -> Assembly:
        """Return an assembly of the bricks of a part, without props."""
        assembly = self._assemblies.get(part)
        if assembly is None:
            beside = self.assembly(larger) if larger is not None and larger != self.whole else self.design
            source = self.whole if beside is self.design else larger
            assembly = beside.copied()
            assembly.remove(self.names_of((source or 0) & ~part), names_smallest=False)
            self._assemblies[part] = assembly
            if len(self._assemblies) > KEPT:
                del self._assemblies[next(iter(self._assemblies))]
        return assembly

    def _judged(self, part: Part, propped: Part, larger: Part | None) -> SubsetAnswer:
        self.verdict_count += 1
        assembly = self.assembly(part, larger)
        verdict = assembly.verdict()
        if verdict.stability is Stability.STABLE:
            return SubsetAnswer(Stability.STABLE)
        if verdict.motion is not None:
            fall = self._learned(part, verdict.motion)
            if not propped & fall.resisting:
                return SubsetAnswer(Stability.UNSTABLE, fall)
        return self._with_props(part, propped, assembly) if propped else SubsetAnswer(Stability.UNDECIDED)

    def _with_props(self, part: Part, propped: Part, assembly: Assembly) -> SubsetAnswer:
        from stability.statics.equilibrium import balance  # noqa: PLC0415 -- it brings numpy
        from stability.statics.self_stress import forces_without_self_stress  # noqa: PLC0415 -- likewise

        problem = assembly.problem()
        held = [contact for name in self.names_of(propped) for contact in self.props[name].contacts]
        problem = replace(problem, contacts=[*problem.contacts, *held])
        tolerances = rounded(problem, Tolerances())
        result = balance(problem, tolerances)
        if result.forces is not None and forces_without_self_stress(problem, result.forces, tolerances) is not None:
            return SubsetAnswer(Stability.STABLE)
        if result.motion is not None:
            return SubsetAnswer(Stability.UNSTABLE, self._learned(part, result.motion))
        return SubsetAnswer(Stability.UNDECIDED)

    def _learned(self, part: Part, motion: Motion) -> SubsetFall:
        moving = self.part_of(motion.velocity)
        bricks = self.design.bricks
        resist = self.part_of(
            other
            for name in sorted(motion.velocity)
            for contact in self.design.contacts(name)
            if (other := contact.upper if contact.lower == name else contact.lower) not in motion.velocity
            and resists(contact, motion, bricks)
        )
        held = (name for name in motion.velocity if name in self.props)
        propping = self.part_of(
            name for name in held if any(resists(contact, motion, bricks) for contact in self.props[name].contacts)
        )
        fall = SubsetFall(moving, resist & ~part, propping)
        self.falls.append(fall)
        return fall

    def learn(self, part: Part) -> None:
        """Learn all falls of a part that does not stand, each reduced to few bricks.

        Fallen bricks are removed before the next fall is searched.
        """
        while part:
            fall = next((fall for fall in self.falls if fall.covers(part, 0)), None)
            if fall is None:
                self.verdict_count += 1
                rest = self.design.copied()
                motion = rest.remove(self.names_of(self.whole & ~part)).motion
                if motion is None:
                    break
                fall = self._learned(part, motion)
            part &= ~fall.moving


# Removal of the bricks of a design one by one such that the remainder stands each time.
#
# Depth-first search, the highest brick first; no part is visited twice. The reverse of a removal order is a building
# order, so this search finds building orders as well. If every branch ends, no order exists, and each end has a proof.


OnProgress = Callable[[int], None]  # is called with the number of verdicts so far


def ignore_progress(_: int) -> None:
    """Ignore the number of verdicts."""


@dataclass(frozen=True, slots=True)
class Descent:
    """Result of a search."""

    order: tuple[BodyId, ...] | None  # of the removed bricks; None if none was found
    exhausted: bool = True  # whether all branches were searched
    # the parts that do not stand, each one removal away from a standing part
    ends: tuple[tuple[Part, SubsetAnswer], ...] = field(default=())

    @property
    def impossible(self) -> bool:
        """Return whether it is proven that no order exists."""
        return self.order is None and self.exhausted and all(a.stability is Stability.UNSTABLE for _, a in self.ends)


def descend(parts: Subsets, start: Part, goal: Part, most: int, on_progress: OnProgress = ignore_progress) -> Descent:
    """Remove all bricks of the standing part `start` that are not in `goal`, with at most `most` verdicts."""
    last, ends = parts.verdict_count + most, dict[Part, SubsetAnswer]()
    path: list[BodyId] = []
    seen = {start}
    waiting = [(start, _next(parts, start, goal))]
    while waiting:
        part, smaller = waiting[-1]
        if part == goal:
            return Descent(tuple(path), ends=tuple(ends.items()))
        for name, less in smaller:
            if less in seen:
                continue
            if parts.verdict_count >= last:
                return Descent(None, exhausted=False, ends=tuple(ends.items()))
            seen.add(less)
            answer = parts.ask(less, part)
            on_progress(parts.verdict_count)
            if answer.stability is Stability.STABLE:
                path.append(name)
                waiting.append((less, _next(parts, less, goal)))
                break
            ends[less] = answer
        else:
            waiting.pop()
            if path:
                path.pop()
    return Descent(None, ends=tuple(ends.items()))


def _next(parts: Subsets, part: Part, goal: Part) -> Iterator[tuple[BodyId, Part]]:
    """Yield the removable bricks, from the top down, with the remainder without each."""
    for name in from_the_top(parts, part & ~goal):
        yield name, part & ~parts.part_of([name])


def from_the_top(parts: Subsets, part: Part) -> list[BodyId]:
    """Return the bricks by the height of their tops, the highest first; ties by name."""
    bricks = parts.design.bricks
    heights = {name: top_W(bricks[name].brick.shape, bricks[name].pose) for name in parts.names_of(part)}
    return sorted(heights, key=lambda name: (-round(heights[name], 9), name))
