"""Joined bricks in motion: those that hold together move as one rigid body until a joint does not bear its loads."""

from collections.abc import Collection, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import dist
from typing import Self

import numpy as np

from stability.contact_law import MohrCoulomb
from stability.engines.protocol import Engine, Link, MeanLoads, RecordsSteps, WeldingEngine
from stability.geometry.placed_shape import inertia_about_axes
from stability.geometry.rows import cross_rows
from stability.geometry.vectors import add, body_axes, inverse, rotate, scale, subtract
from stability.graph import components, reached
from stability.joints import JointRule, Joints
from stability.model import AT_REST, BodyId, BodyState, Brick, Vec3, convex
from stability.problem import Contact, Motion, Placed, Problem, Wrench
from stability.stabilizers.protocol import BrickObserver
from stability.statics.assembly import Assembly
from stability.statics.borne_loads import BorneLoads
from stability.statics.opened_joints import Pair, fastest_point, joined_pairs, opened_pairs
from stability.statics.structure import Structure

# Joints that yield hold their bodies together by their strength until these have moved apart, and then open for good.
#
# All joints whose bodies move against each other in the motion at which they yield do so as a whole. A joint that is
# not ductile opens at once: as soon as its points have parted, nothing pulls any more, and the contact is dry.
#
# The loads on the joints of a body in motion are those on its bricks, with their inertia (d'Alembert). They are means
# over a time step of the engine, so a hit lasts at least as long as a step. A step that a joint does not bear is
# repeated: during this step the joint passes on its strength, also if it opens after it.


QUIET = 1e-4  # share of the fastest brick: slower ones stay frozen


@dataclass(frozen=True, slots=True)
class Carried:
    """Motion that a hand prescribes to a body during a step, in which the body does not turn."""

    brick: BodyId  # in the hand
    acceleration_W: Vec3  # [m/s2]


class JoinedBody:
    """Joined bricks that move as one rigid body."""

    def __init__(self, problem: Problem) -> None:
        """Create from the bricks, their contacts with each other, and their weights, before they move."""
        self.problem = problem
        self.names = tuple(problem.bricks)
        self._borne = BorneLoads(problem)
        placed = tuple(problem.bricks.values())
        self._axes = np.array(body_axes(placed[0].pose.orientation)).T
        self._masses = np.array([each.brick.mass for each in placed])
        centres = np.array([each.pose.position_W for each in placed])
        self._arms = centres - self._masses @ centres / self._masses.sum()
        self._inertias = np.array([inertia_about_axes(each.brick, each.pose.orientation) for each in placed])
        squares = np.einsum("ni,ni->n", self._arms, self._arms)
        spread = squares[:, None, None] * np.eye(3) - np.einsum("ni,nj->nij", self._arms, self._arms)
        self._inertia = self._inertias.sum(axis=0) + np.einsum("n,nij->ij", self._masses, spread)

    def opens_under(self, means: MeanLoads, state: BodyState, carried: "Carried | None" = None) -> set[Pair]:
        """Return the joints that do not bear mean contact loads; `state` is that of the first brick."""
        motion = self._borne.yields_under(self._loads(means, state, carried))
        if motion is None:
            return set()
        return opened_pairs(self.problem, motion) or joined_pairs(self.problem.contacts)

    def _loads(self, means: MeanLoads, state: BodyState, carried: "Carried | None") -> dict[BodyId, Wrench]:
        """Return the loads on the bricks with their inertia, in the axes of the problem.

        Weights are left out, as they cancel out with the inertia of the free fall. A hand exerts on its brick what the
        acceleration of the body needs besides all other loads.
        """
        turn = np.array(body_axes(state.pose.orientation)).T @ self._axes.T
        loads = np.array([means.get(name, (0.0,) * 6) for name in self.names])
        forces, torques, spin = loads[:, :3] @ turn, loads[:, 3:] @ turn, turn.T @ state.angular_velocity_W
        if carried is not None:
            weight = np.sum([load.force_W for load in self.problem.loads.values()], axis=0) @ turn
            held = self.names.index(carried.brick)
            forces[held] += self._masses.sum() * (np.array(carried.acceleration_W) @ turn) - weight - forces.sum(axis=0)
            torques[held] -= (torques + cross_rows(self._arms, forces)).sum(axis=0)
        acceleration = forces.sum(axis=0) / self._masses.sum()
        spins = np.broadcast_to(spin, self._arms.shape)
        own = torques - cross_rows(spins, self._inertias @ spin)
        gyration = cross_rows(spin[None], (self._inertia @ spin)[None])[0]
        change = np.linalg.solve(self._inertia, (torques + cross_rows(self._arms, forces)).sum(axis=0) - gyration)
        turning = cross_rows(np.broadcast_to(change, self._arms.shape), self._arms)
        accelerations = acceleration + turning + cross_rows(spins, cross_rows(spins, self._arms))
        forces = forces - self._masses[:, None] * accelerations
        torques = own - self._inertias @ change
        return {
            name: Wrench(tuple(force), tuple(torque))
            for name, force, torque in zip(self.names, forces.tolist(), torques.tolist(), strict=True)
        }

    def without(self, opened: Collection[Pair], removed: Collection[BodyId] = ()) -> "Iterator[JoinedBody]":
        """Yield the bodies of the bricks that still hold together."""
        contacts = [
            contact
            for contact in self.problem.contacts
            if contact.law.is_cone or frozenset((contact.lower, contact.upper)) not in opened
        ]
        bricks = {name: placed for name, placed in self.problem.bricks.items() if name not in removed}
        yield from _bodies(Problem(bricks, contacts, self.problem.loads))


def _bodies(problem: Problem) -> Iterator[JoinedBody]:
    """Yield the bodies of several bricks that joints hold together."""
    beside: dict[BodyId, list[BodyId]] = {name: [] for name in problem.bricks}
    for one, other in joined_pairs(problem.contacts):
        if one in beside and other in beside:
            beside[one].append(other)
            beside[other].append(one)
    for part in components(beside, beside.__getitem__):
        if len(part) > 1:
            yield JoinedBody(
                Problem(
                    {name: placed for name, placed in problem.bricks.items() if name in part},
                    [each for each in problem.contacts if each.lower in part and each.upper in part],
                    {name: load for name, load in problem.loads.items() if name in part},
                )
            )


@dataclass(frozen=True, slots=True, eq=False)
class YieldingJoint:
    """Joint that has yielded: its links hold two bodies together until their ends are too far apart."""

    links: tuple[Link, ...]
    ductile: float  # greatest distance of the ends [m]

    def parting(self, states: Mapping[BodyId, BodyState]) -> float:
        """Return the greatest distance of the ends of a link [m]; a body without a state is fixed."""
        return max(
            dist(_placed(link.at_lower, states.get(link.lower)), _placed(link.at_upper, states.get(link.upper)))
            for link in self.links
        )


def _placed(point: Vec3, state: BodyState | None) -> Vec3:
    """Return a point in axes of a body in W [m]."""
    return point if state is None else add(state.pose.position_W, rotate(state.pose.orientation, point))


def _links(contact: Contact, bodies: Mapping[BodyId, Placed]) -> Iterator[Link]:
    """Yield a link for each point of a contact of a joint; a body that is not among the bricks is fixed."""
    law, lower, upper = contact.law, bodies.get(contact.lower), bodies[contact.upper]
    if isinstance(law, MohrCoulomb):
        (normal_W,) = contact.normals_W
        normal = normal_W if lower is None else rotate(inverse(lower.pose.orientation), normal_W)
        for point_W in contact.points_W:
            yield Link(
                contact.lower, contact.upper, _seen_from(lower, point_W), _seen_from(upper, point_W), normal, law
            )


def _seen_from(body: Placed | None, point_W: Vec3) -> Vec3:
    if body is None:
        return point_W
    return rotate(inverse(body.pose.orientation), subtract(point_W, body.pose.position_W))


@dataclass(frozen=True, slots=True, eq=False)
class Overload:
    """Frozen bricks that do not bear loads, and the motion at which they yield."""

    problem: Problem
    motion: Motion  # empty if it is not known
    loaded: tuple[BodyId, ...]

    @property
    def moving(self) -> list[BodyId]:
        """The bricks that move: all if the motion is not known."""
        fastest = {
            name: fastest_point(self.problem.bricks[name], *twist) for name, twist in self.motion.velocity.items()
        }
        most = max(fastest.values(), default=0.0)
        return [name for name, speed in fastest.items() if speed > QUIET * most] or list(self.problem.bricks)

    def joined_with(self, bricks: Collection[BodyId]) -> set[Pair]:
        """Return the pairs of bodies with a joint, at least one of which is among some bricks."""
        return {pair for pair in joined_pairs(self.problem.contacts) if not pair.isdisjoint(bricks)}


@dataclass
class JoinedBricks(BrickObserver):
    """The joints of the bricks of one engine that have moved, and the bodies that they hold together."""

    engine: Engine
    welder: WeldingEngine | None
    joints: Joints  # those that hold now
    recorder: RecordsSteps | None = None
    _yielding: dict[Pair, YieldingJoint] = field(default_factory=dict, init=False)  # also those that hold again
    _of: dict[BodyId, JoinedBody] = field(default_factory=dict, init=False)  # by brick
    _in_hands: set[BodyId] = field(default_factory=set, init=False)
    _before: dict[BodyId, Vec3] = field(default_factory=dict, init=False)  # velocities of bricks in hands [m/s]
    _welded: set[BodyId] = field(default_factory=set, init=False)
    _structures: dict[BodyId, "_Structure"] = field(default_factory=dict, init=False)  # by frozen brick

    def __contains__(self, brick: object) -> bool:
        return brick in self._of

    @property
    def bodies(self) -> list[JoinedBody]:
        """The bodies of several bricks."""
        return list(dict.fromkeys(self._of.values()))

    def released(
        self, bricks: Collection[Placed], held: Collection[Pair], assembly: Assembly, *, passes: bool = False
    ) -> None:
        """Handle bricks that begin to move; of their joints only the `held` ones have not yielded.

        Those that yield to the loads of a step pass on their strength during this step.
        """
        if not self.joints.rules or not bricks:
            return
        names = {placed.brick.id for placed in bricks}
        if passes or any(rule.joint is not None and rule.joint.ductile for rule in self.joints.rules):
            problem = self._with_neighbours(bricks, assembly)
            pairs = {pair for pair in joined_pairs(problem.contacts) - set(held) if not pair.isdisjoint(names)}
            self._yield(problem, pairs, passes=passes)
        self._move(bricks, held, assembly)

    def arrived(self, bricks: Collection[Placed], assembly: Assembly) -> None:
        """Handle bricks that come to rest after a flight: no joint is made with them."""
        new = [placed for placed in bricks if placed.brick.id not in self.joints.moved]
        if self.joints.rules and new:
            self._move(new, (), assembly)

    def _move(self, bricks: Collection[Placed], held: Collection[Pair], assembly: Assembly) -> None:
        """Keep only the `held` joints of bricks, and make bodies of those that these hold together."""
        names = {placed.brick.id for placed in bricks}
        before = {pair for pair in self.joints.held if not pair & names}
        now = frozenset((*before, *(pair for pair in held if pair <= names)))
        self._change(assembly, replace(self.joints, moved=frozenset((*self.joints.moved, *names)), held=now))
        structure = Structure((), (), assembly.friction, assembly.gravity, assembly.tolerances, self.joints)
        for placed in _by_height(bricks):
            structure.put(placed)
        group = list(structure.bricks)
        self._add(_bodies(structure.problem(group, structure.contacts_of(group))))

    # --- joints that have yielded -------------------------------------------------------------------------------------

    def _with_neighbours(self, bricks: Collection[Placed], assembly: Assembly) -> Problem:
        """Return the problem of bricks that begin to move and of the frozen ones beside them."""
        site = assembly.planes, assembly.tables, assembly.friction, assembly.gravity, assembly.tolerances
        structure = Structure(*site, self.joints)
        moving = {placed.brick.id for placed in bricks}
        frozen = [each for name, each in assembly.bricks.items() if name not in moving and _is_near(each, bricks)]
        for placed in _by_height([*bricks, *frozen]):
            structure.put(placed)
        group = list(structure.bricks)
        return structure.problem(group, structure.contacts_of(group))

    def _yield(self, problem: Problem, pairs: Collection[Pair], *, passes: bool) -> None:
        """Let joints hold by their strength from now on."""
        by_pair: dict[Pair, list[Link]] = {}
        bodies = {**problem.bricks, **self._held_by_hands()}
        for contact in problem.contacts:
            pair = frozenset((contact.lower, contact.upper))
            joint = self.joints.of(contact.lower, contact.upper)
            if pair in pairs and pair not in self._yielding and joint is not None and (passes or joint.ductile):
                by_pair.setdefault(pair, []).extend(_links(contact, bodies))
        for pair, links in by_pair.items():
            joint = self.joints.of(*pair)
            if links and joint is not None:
                self._yielding[pair] = YieldingJoint(tuple(links), joint.ductile)
        self._structures.clear()

    def _held_by_hands(self) -> dict[BodyId, Placed]:
        """Return the bricks in hands, where they are now."""
        masses, states = self.engine.masses(), self.engine.states(sorted(self._in_hands))
        shapes = {name: convex(self.engine.shape(name)) for name in states}
        return {
            name: Placed(Brick(name, shape, masses[name]), states[name].pose)
            for name, shape in shapes.items()
            if shape is not None
        }

    @property
    def links(self) -> tuple[Link, ...]:
        """The points at which joints that have yielded hold bodies together by their strength."""
        return tuple(
            link for pair, joint in self._yielding.items() if pair not in self.joints.held for link in joint.links
        )

    def is_ductile(self, pair: Pair) -> bool:
        """Return whether a joint that has yielded still holds."""
        return pair in self._yielding and self._yielding[pair].ductile > 0.0

    def parted(self) -> frozenset[Pair]:
        """Open the joints whose bodies have moved apart by more than they bear, after a step; return ductile ones."""
        active = {pair: joint for pair, joint in self._yielding.items() if pair not in self.joints.held}
        known = self.engine.masses()
        states = self.engine.states(sorted({name for pair in active for name in pair if name in known}))
        open_now = {pair: joint for pair, joint in active.items() if joint.parting(states) > joint.ductile}
        open_now |= {pair: joint for pair, joint in active.items() if not joint.ductile}
        for pair in open_now:
            del self._yielding[pair]
        if open_now:
            self._structures.clear()
        return frozenset(pair for pair, joint in open_now.items() if joint.ductile)

    def hold_again(self, resting: Collection[BodyId], assembly: Assembly) -> None:
        """Let the joints of bricks at rest that have yielded hold them, as far as they touch."""
        still = {*resting, *assembly.bricks, *self.engine.fixed()}
        again = {pair for pair in self._yielding if pair <= still and pair not in self.joints.held}
        if again:
            self._change(assembly, replace(self.joints, held=frozenset((*self.joints.held, *again))))

    def yield_again(self, bricks: Collection[BodyId], assembly: Assembly) -> None:
        """Let the joints of bricks that do not rest after all yield as before."""
        names = set(bricks)
        yielding = {pair for pair in self._yielding if pair in self.joints.held and not pair.isdisjoint(names)}
        if yielding:
            self._change(assembly, replace(self.joints, held=frozenset(self.joints.held) - yielding))

    def with_rules(self, rules: Sequence[JointRule]) -> Joints:
        """Return the joints that hold now by other rules: bricks that have moved get no new ones."""
        return replace(self.joints, rules=tuple(rules))

    def rejoined(self, assembly: Assembly) -> None:
        """Handle other joints, which the assembly has already: those that are cut in bodies open."""
        self.joints = assembly.joints
        self._structures.clear()
        for pair in list(self._yielding):
            if replace(self.joints, held=(pair,)).of(*pair) is None:
                del self._yielding[pair]
        for body in self.bodies:
            cut = {pair for pair in joined_pairs(body.problem.contacts) if self.joints.of(*pair) is None}
            if cut:
                self.open(body, cut, assembly)

    def open(self, body: JoinedBody, pairs: Collection[Pair], assembly: Assembly) -> None:
        """Let joints of a body yield."""
        self._yield(body.problem, pairs, passes=True)
        self._change(assembly, replace(self.joints, held=frozenset(self.joints.held) - frozenset(pairs)))
        self._drop(body)
        self._add(body.without(pairs))

    def whole(self, resting: list[Placed]) -> list[Placed]:
        """Return the resting bricks without those of bodies of which other bricks do not rest."""
        names = {placed.brick.id for placed in resting}
        return [
            each for each in resting if each.brick.id not in self or names.issuperset(self._of[each.brick.id].names)
        ]

    def split_by(self, released: Container[BodyId], standing: Container[BodyId]) -> list[BodyId]:
        """Return the standing bricks of the bodies of which other bricks were released."""
        return [
            name
            for body in self.bodies
            if any(other in released for other in body.names)
            for name in body.names
            if name in standing
        ]

    def _change(self, assembly: Assembly, joints: Joints) -> None:
        self.joints = joints
        assembly.hold_by(joints)

    def _add(self, bodies: Iterator[JoinedBody]) -> None:
        for body in bodies:
            self._of |= dict.fromkeys(body.names, body)

    def _drop(self, body: JoinedBody) -> None:
        if self.welder is not None and self._welded.issuperset(body.names):
            self.welder.unweld(body.names[0])
        self._forget(body)

    def _forget(self, body: JoinedBody) -> None:
        for name in body.names:
            self._of.pop(name, None)
            self._welded.discard(name)

    # --- engine -------------------------------------------------------------------------------------------------------

    def weld(self) -> None:
        """Weld all bodies, and link those whose joints have yielded, for the next step."""
        if self.welder is None:
            return
        for body in self.bodies:
            if not self._welded.issuperset(body.names):
                self.welder.weld(body.names)
                self._welded.update(body.names)
        if self.recorder is not None:
            self.recorder.link(self.links)
        carried = [name for name in sorted(self._in_hands) if name in self._of]
        self._before = {name: state.velocity_W for name, state in self.engine.states(carried).items()}

    def unwelded(self) -> None:
        """Handle a motion without the engine, which moves all bricks one by one."""
        self._welded.clear()

    # --- loads --------------------------------------------------------------------------------------------------------

    def opening(self, means: MeanLoads) -> list[tuple[JoinedBody, set[Pair]]]:
        """Return the bodies with joints that do not bear mean contact loads, and these joints."""
        bodies = self.bodies
        states = self.engine.states([body.names[0] for body in bodies])
        opening = [
            (body, body.opens_under(means, states[body.names[0]], self._carried(body, states[body.names[0]])))
            for body in bodies
        ]
        return [(body, pairs) for body, pairs in opening if pairs]

    def _carried(self, body: JoinedBody, state: BodyState) -> Carried | None:
        """Return the motion that a hand prescribed to a body in the last step."""
        brick = next((name for name in body.names if name in self._before), None)
        if brick is None or self.recorder is None:
            return None
        change_W = subtract(state.velocity_W, self._before[brick])
        return Carried(brick, scale(1.0 / self.recorder.hit_duration(), change_W))

    def overloads(self, means: MeanLoads, assembly: Assembly, ground_W: Vec3 = AT_REST) -> list[Overload]:
        """Return the frozen structures with joints that do not bear mean loads in addition to their weight.

        On ground that accelerates [m/s2] the inertia of their bricks is added.
        """
        loads: dict[BodyId, tuple[_Structure, dict[BodyId, Wrench]]] = {}
        for name, (a, b, c, d, e, f) in means.items():
            if name in assembly.bricks and (structure := self._structure(name, assembly)).borne is not None:
                _, on_bricks = loads.setdefault(min(structure.bricks), (structure, {}))
                on_bricks[name] = Wrench((a, b, c), (d, e, f))
        overloads = []
        for structure, on_bricks in loads.values():
            if ground_W != AT_REST:
                _add_inertia(on_bricks, structure.bricks, assembly, ground_W)
            if structure.borne is not None and (motion := structure.borne.yields_under(on_bricks)) is not None:
                overloads.append(
                    Overload(structure.borne.problem, motion, tuple(sorted(means.keys() & on_bricks.keys())))
                )
        return overloads

    def is_in_structure(self, brick: BodyId, assembly: Assembly) -> bool:
        """Check that a frozen brick is part of a structure with joints."""
        return (
            bool(self.joints.rules) and brick in assembly.bricks and self._structure(brick, assembly).borne is not None
        )

    def _structure(self, brick: BodyId, assembly: Assembly) -> "_Structure":
        if brick not in self._structures:
            bricks = reached([brick], lambda name: _touched(assembly, name))
            problem = assembly.problem(bricks)
            linked = {name for link in self.links for name in (link.lower, link.upper)}
            has_joints = problem.has_joints or not linked.isdisjoint(bricks)
            borne = BorneLoads(problem, problem.loads) if has_joints else None
            self._structures |= dict.fromkeys(bricks, _Structure(frozenset(bricks), borne))
        return self._structures[brick]

    # --- hands --------------------------------------------------------------------------------------------------------
    #
    # What is joined with a brick in a hand that moves is one body with it, and is carried as a whole. A hand at rest
    # holds its brick like a fixed body.

    def joined_to(self, brick: BodyId, assembly: Assembly) -> set[BodyId]:
        """Return the frozen bricks that joints hold together with a brick, itself included."""
        if not self.joints.rules or brick not in assembly.bricks:
            return set()
        return reached([brick], lambda name: [body for body in _joined_to(assembly, name) if body in assembly.bricks])

    def take(self, brick: BodyId) -> None:
        """Handle a hand taking a brick: its joints hold on."""
        self._in_hands.add(brick)
        self._welded.clear()  # the engine has parted its body

    def put_down(self, brick: BodyId) -> list[BodyId]:
        """End the body of a brick in a hand that has come to rest; return the other bricks of the body."""
        self._welded.clear()
        body = self._of.get(brick)
        if body is None:
            return []
        self._forget(body)
        return [name for name in body.names if name != brick]

    def let_go(self, brick: BodyId) -> None:
        """Handle a hand releasing a brick."""
        self._in_hands.discard(brick)
        self._welded.clear()

    # --- life cycle ---------------------------------------------------------------------------------------------------

    def frozen(self, bricks: Collection[BodyId]) -> None:
        """Drop the bodies of frozen bricks; their joints still hold."""
        self._structures.clear()
        for brick in bricks:
            if brick in self._of:
                self._forget(self._of[brick])

    def woken(self, bricks: Collection[BodyId]) -> None:
        """Forget the structures, which have changed."""
        self._structures.clear()

    def removed(self, bricks: Collection[BodyId]) -> None:
        """Drop removed bricks, whose bodies the engine has unwelded; those in hands are not judged, but stay."""
        self._structures.clear()
        bricks = [brick for brick in bricks if brick not in self._in_hands]
        for pair in list(self._yielding):
            if not pair.isdisjoint(bricks):
                del self._yielding[pair]
        for body in {self._of[brick] for brick in bricks if brick in self._of}:
            self._forget(body)
            self._add(body.without((), bricks))

    def absorb(self, other: Self) -> None:
        """Take over the records of another instance."""
        self._of |= other._of
        self._welded |= other._welded
        self._yielding |= other._yielding
        moved, held = {*self.joints.moved, *other.joints.moved}, {*self.joints.held, *other.joints.held}
        self.joints = replace(self.joints, moved=frozenset(moved), held=frozenset(held))


@dataclass(frozen=True, slots=True, eq=False)
class _Structure:
    """Connected frozen bricks."""

    bricks: frozenset[BodyId]
    borne: BorneLoads | None  # None without joints


def _add_inertia(loads: dict[BodyId, Wrench], bricks: Collection[BodyId], assembly: Assembly, ground_W: Vec3) -> None:
    for name in bricks:
        own = loads.get(name, Wrench(AT_REST))
        inertia_W = scale(-assembly.bricks[name].brick.mass, ground_W)
        loads[name] = Wrench(add(own.force_W, inertia_W), own.torque_W)


def _by_height(bricks: Collection[Placed]) -> list[Placed]:
    return sorted(bricks, key=lambda placed: placed.pose.position_W[::-1])


def _is_near(frozen: Placed, bricks: Collection[Placed]) -> bool:
    """Return whether a brick may touch some others, by their bounding spheres."""
    return any(
        dist(frozen.pose.position_W, other.pose.position_W)
        <= frozen.brick.shape.length + other.brick.shape.length  # more than both radii
        for other in bricks
    )


def _joined_to(assembly: Assembly, brick: BodyId) -> Iterator[BodyId]:
    for pair in joined_pairs(assembly.contacts(brick)):
        yield from pair - {brick}


def _touched(assembly: Assembly, brick: BodyId) -> list[BodyId]:
    bodies = (body for contact in assembly.contacts(brick) for body in (contact.lower, contact.upper))
    return [body for body in bodies if body in assembly.bricks]
