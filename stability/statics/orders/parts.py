"""Which parts of a design stand, and which fall: nothing is asked twice, and each fall that is proven is learned from.

A motion that no contact resists is one wherever the bricks that move are there, and nothing that would resist it: only
bricks that move take part in its power, and what is at rest and does not resist may be there or not. So one proof of a
fall settles all such parts. Nothing alike holds of what stands: a brick less may be a counterweight less.

A part is a set of bits, one a brick, in order of names.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

from stability.model import BodyId
from stability.statics.assembly import Assembly
from stability.statics.facts import Motion, Stability, Tolerances
from stability.statics.orders.props import Prop
from stability.statics.orders.resisting import resists
from stability.statics.rounding import rounded

Part: TypeAlias = int

KEPT = 32  # assemblies that are kept for parts next to them


@dataclass(frozen=True, slots=True)
class Fall:
    """A proven fall, and for which other parts the same proof holds."""

    moving: Part  # which must be there
    absent: Part  # which must not be there: they would resist, even if only by staying at rest
    resisting: Part  # whose props could resist it

    def settles(self, part: Part, propped: Part) -> bool:
        """Whether it proves that a part falls, with props under some bricks."""
        return part & self.moving == self.moving and not part & self.absent and not propped & self.resisting


@dataclass(frozen=True, slots=True)
class Answer:
    """What is known of a part."""

    stability: Stability
    fall: Fall | None = None  # of what is UNSTABLE


class Parts:
    """A design that stands, or is to stand, and what is known of its parts."""

    def __init__(self, design: Assembly, props: Mapping[BodyId, Prop] | None = None) -> None:
        """Nothing is asked yet. `props`: those that may be used; none are, unless `propped` says so."""
        self.design = design
        self.names = sorted(design.bricks)
        self.whole: Part = (1 << len(self.names)) - 1
        self.props = props or {}
        self.propped: Part = 0
        self.asked = 0  # how many verdicts were needed
        self.falls: list[Fall] = []
        self._bit = {name: 1 << index for index, name in enumerate(self.names)}
        self._known: dict[tuple[Part, Part], Answer] = {}
        self._assemblies: dict[Part, Assembly] = {}
        self._touching = {name: self._neighbours(name) for name in self.names}

    def _neighbours(self, name: BodyId) -> Part:
        others = {body for contact in self.design.contacts(name) for body in (contact.lower, contact.upper)}
        return self.part_of(others - {name})

    def part_of(self, bricks: Iterable[BodyId]) -> Part:
        """The part that some bricks are; what is no brick is passed over."""
        part = 0
        for name in bricks:
            part |= self._bit.get(name, 0)
        return part

    def names_of(self, part: Part) -> list[BodyId]:
        """The bricks of a part, by name."""
        return [name for name in self.names if self._bit[name] & part]

    def touching(self, part: Part) -> Part:
        """All that touches a brick of a part."""
        found = 0
        for name in self.names_of(part):
            found |= self._touching[name]
        return found

    def components(self, part: Part) -> list[Part]:
        """The pieces of a part that do not touch each other."""
        found = []
        while part:
            piece, front = 0, part & -part
            while front:
                piece |= front
                front = self.touching(front) & part & ~piece
            found.append(piece)
            part &= ~piece
        return found

    def ask(self, part: Part, larger: Part | None = None) -> Answer:
        """Whether a part stands, with props under those of its bricks that have one.

        `larger`: a part with a few bricks more that was asked just now, which makes it cheaper.
        """
        propped = self.propped & part
        known = self._known.get((part, propped))
        if known is None:
            fall = next((fall for fall in self.falls if fall.settles(part, propped)), None)
            known = Answer(Stability.UNSTABLE, fall) if fall is not None else self._judged(part, propped, larger)
            self._known[part, propped] = known
        return known

    def assembly(self, part: Part, larger: Part | None = None) -> Assembly:
        """The bricks of a part, without props."""
        found = self._assemblies.get(part)
        if found is None:
            beside = self.assembly(larger) if larger is not None and larger != self.whole else self.design
            source = self.whole if beside is self.design else larger
            found = beside.copied()
            found.remove(self.names_of((source or 0) & ~part), names_smallest=False)
            self._assemblies[part] = found
            if len(self._assemblies) > KEPT:
                del self._assemblies[next(iter(self._assemblies))]
        return found

    def _judged(self, part: Part, propped: Part, larger: Part | None) -> Answer:
        self.asked += 1
        assembly = self.assembly(part, larger)
        verdict = assembly.verdict()
        if verdict.stability is Stability.STABLE:
            return Answer(Stability.STABLE)
        if verdict.motion is not None:
            fall = self._learned(part, verdict.motion)
            if not propped & fall.resisting:
                return Answer(Stability.UNSTABLE, fall)
        return self._with_props(part, propped, assembly) if propped else Answer(Stability.UNDECIDED)

    def _with_props(self, part: Part, propped: Part, assembly: Assembly) -> Answer:
        from stability.statics.solvers.equilibrium import balance  # noqa: PLC0415 -- it brings numpy
        from stability.statics.solvers.self_stress import honest_forces  # noqa: PLC0415 -- likewise

        problem = assembly.problem()
        held = [contact for name in self.names_of(propped) for contact in self.props[name].contacts]
        problem = replace(problem, contacts=[*problem.contacts, *held])
        tolerances = rounded(problem, Tolerances())
        found = balance(problem, tolerances)
        if found.forces is not None and honest_forces(problem, found.forces, tolerances) is not None:
            return Answer(Stability.STABLE)
        if found.motion is not None:
            return Answer(Stability.UNSTABLE, self._learned(part, found.motion))
        return Answer(Stability.UNDECIDED)

    def _learned(self, part: Part, motion: Motion) -> Fall:
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
        fall = Fall(moving, resist & ~part, propping)
        self.falls.append(fall)
        return fall

    def learn(self, part: Part) -> None:
        """Learn from all falls of a part that does not stand, each of as few bricks as are found.

        What was found to fall is taken away before the next is looked for.
        """
        while part:
            fall = next((fall for fall in self.falls if fall.settles(part, 0)), None)
            if fall is None:
                self.asked += 1
                rest = self.design.copied()
                motion = rest.remove(self.names_of(self.whole & ~part)).motion
                if motion is None:
                    break
                fall = self._learned(part, motion)
            part &= ~fall.moving
