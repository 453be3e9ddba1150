"""Keeps the bricks of a structure proven, as far as possible, while bricks are added and removed.

A new brick is proven if its weight lies in its own load core, a cheap test. Other bricks go through the cascade, whose
result is cached until something near them changes.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from stability.model import BodyId
from stability.problem import Placed, Stability, Stage, Verdict
from stability.statics.cascade import Partners, judge, prove_together
from stability.statics.journal import JournaledDict
from stability.statics.ledger import Ledger, LedgerState, ProofGroup
from stability.statics.structure import Structure, StructureState

COSTLIEST_FIRST = tuple(reversed(Stage))
LARGE = 60  # bricks: with more, judging each brick would solve nearly the same program again


@dataclass(frozen=True, slots=True)
class ProverState:
    """Snapshot of a prover."""

    structure: StructureState
    ledger: LedgerState
    unproven: frozenset[BodyId]
    in_doubt: Mapping[BodyId, Verdict]


class Prover:
    """Proofs of the bricks of one structure, and the bricks without a proof."""

    def __init__(self, structure: Structure) -> None:
        """Start without bricks."""
        self.structure = structure
        self.ledger = Ledger(structure.journal)
        self._unproven: JournaledDict[BodyId, None] = JournaledDict(structure.journal)
        self._in_doubt: JournaledDict[BodyId, Verdict] = JournaledDict(structure.journal)  # results for unproven bricks
        self._partners = Partners(structure, self.ledger.with_partners)

    def put(self, bricks: Sequence[Placed]) -> None:
        """Place bricks, each after its supports."""
        if self.structure.put_together(bricks):
            self._prove_joined([placed.brick.id for placed in bricks])
            return
        for placed in bricks:
            parted = [self.structure.bricks[name] for name in self.structure.parted_by(placed)]
            if parted:  # bricks that stood across a gap stand on the brick that fills it
                self.take([each.brick.id for each in parted])
            for each in (placed, *parted):
                self.structure.put(each)
                self._prove_by_core(each.brick.id)
        self._discard_verdicts([placed.brick.id for placed in bricks])

    def take(self, bricks: Sequence[BodyId]) -> list[BodyId]:
        """Remove bricks and the proofs that depended on them; return the bricks to be judged again."""
        structure = self.structure
        self._discard_verdicts(bricks)
        affected = structure.with_all_above(bricks)
        while True:
            larger = structure.with_all_above(affected | self.ledger.strike(affected))
            if len(larger) == len(affected):
                break
            affected = larger
        for name in bricks:
            structure.take(name)
        again = structure.upwards(affected.difference(bricks))
        self._mark_proven(bricks)
        for name in again:
            del structure.cores[name]
        for name in again:
            structure.find_core(name)
            self._prove_by_core(name)
        return again

    def state(self) -> ProverState:
        """Return a snapshot."""
        known = frozenset(self._unproven), dict(self._in_doubt)
        return ProverState(self.structure.state(), self.ledger.state(), *known)

    def restore(self, state: ProverState) -> None:
        """Restore the results for bricks at unchanged places."""
        self.structure.restore(state.structure)
        self.ledger.restore(state.ledger)
        self._unproven.replace(dict.fromkeys(state.unproven))
        self._in_doubt.replace(state.in_doubt)

    def all_proven(self) -> bool:
        """Return whether every brick has a proof."""
        return not self._unproven

    def prove(self, names_smallest: bool) -> Verdict | None:
        """Judge the bricks without a proof, from the lowest on; None if all are proven now."""
        worst: Verdict | None = None
        together = True
        for name in self.structure.upwards(self._unproven):
            together = together and self._prove_component(name)
            if name not in self._unproven:
                continue
            verdict = self._in_doubt.get(name) or self._judge_alone(name, names_smallest)
            worst = verdict or worst
            if worst is not None and worst.stability is Stability.UNSTABLE:
                break  # falling bricks must be removed before others can be judged
        return worst

    def costliest_stage(self, bricks: Sequence[BodyId]) -> Stage | None:
        """Return the most expensive stage among the proofs of these bricks; None without a proof."""
        if len(bricks) == 1:
            return self.ledger.stage(bricks[0])
        stages = {self.ledger.stage(name) for name in bricks}
        return next((stage for stage in COSTLIEST_FIRST if stage in stages), None)

    def _prove_by_core(self, name: BodyId) -> None:
        """Prove a brick by its load core if its weight lies in it."""
        if self._is_carried(name):
            self.ledger.prove_by_core(name)
            self._unproven.pop(name, None)
        else:
            self._unproven[name] = None

    def _prove_joined(self, names: Sequence[BodyId]) -> None:
        """Prove bricks by their load cores; if one of them is not, all that are connected are judged together."""
        if not self.structure.is_joined():
            for name in names:
                self._prove_by_core(name)
            return
        left = dict.fromkeys(names)
        while left:
            name = next(iter(left))
            together = self.structure.by_turn(self.structure.component(name))
            if all(self._is_carried(each) for each in together):
                for each in together:
                    self.ledger.prove_by_core(each)
            else:
                self._unproven |= dict.fromkeys(together)
            for each in together:
                del left[each]

    def _is_carried(self, name: BodyId) -> bool:
        """Return whether the weight of a brick lies in its load core."""
        return self.structure.cores[name].carries(self.structure.weights[name].at) and self.structure.is_upright(name)

    def _judge_alone(self, name: BodyId, names_smallest: bool) -> Verdict | None:
        """Return the verdict of the cascade on a brick without a proof, cached until something near it changes."""
        answer = judge(self.structure, name, self._partners, names_smallest, self._unproven)
        if answer.group is not None:
            self._enter(answer.group)
            return None
        if answer.verdict is not None:
            about = set(answer.verdict.moving)
            if about & self.structure.component(name):  # a fall elsewhere may change without this brick
                about.add(name)
            self._in_doubt |= dict.fromkeys(self._unproven.keys() & about, answer.verdict)
        return answer.verdict

    def _prove_component(self, name: BodyId) -> bool:
        """Try to prove all bricks around a brick with a large program at once; return False if that fails."""
        if name not in self._unproven or name in self._in_doubt or self.structure.is_joined():
            return True
        if self.structure.may_roll(name):
            return True
        if len(self._partners.of({name} | self.structure.below([name]))) < LARGE:
            return True
        group = prove_together(self.structure, self._unproven.keys() & self.structure.component(name), self._partners)
        if group is not None:
            self._enter(group)
        return group is not None

    def _enter(self, group: ProofGroup) -> None:
        self.ledger.enter(group)
        self._mark_proven(group.members)

    def _mark_proven(self, bricks: Iterable[BodyId]) -> None:
        for name in bricks:
            self._unproven.pop(name, None)

    def _discard_verdicts(self, names: Iterable[BodyId]) -> None:
        """Discard the results for all bricks connected with these."""
        left = set(names) if self._in_doubt else set()
        while left:
            connected = self.structure.component(left.pop())
            left -= connected
            for other in connected:
                self._in_doubt.pop(other, None)
