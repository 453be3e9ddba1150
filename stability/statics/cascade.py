"""The cascade of stability tests, cheapest first: the first proof decides."""

from collections.abc import Callable, Collection, Iterator, Sequence, Set
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stability.graph import from_the_top
from stability.model import BodyId
from stability.name_order import names_text
from stability.problem import Contact, Motion, Problem, Stability, Stage, Verdict
from stability.statics.fall_description import described
from stability.statics.ledger import ProofGroup
from stability.statics.load_core import carries_upright
from stability.statics.propagation import Failure, propagate
from stability.statics.structure import Structure, overlap_in_words
from stability.statics.tipping import Fall, lies_over, tipping
from stability.statics.upright_forces import landings_of, upright_group, vertical_forces

if TYPE_CHECKING:
    from stability.statics.equilibrium import Balance


# Falls of the upper part of an assembly: some bricks and all that they carry move, and the rest is held fixed.


CUT = 60  # bricks: up to this size of a falling group the smallest upper part that falls as one body is searched
LITTLE = 8  # bricks: up to this size solving a program costs about as much as setting it up


def small_fall(
    structure: Structure, doubted: Collection[BodyId], first: BodyId, most: int
) -> tuple[Problem, Motion] | None:
    """Return the problem and the motion of a fall of one of the `doubted` bricks with all bricks above it, or None.

    Often few bricks of a falling load move at first, and finding these costs less than judging the whole load. Parts (a
    brick and all bricks above it) of more than `LITTLE` bricks are skipped; for the part of `first` this limit is
    `most` instead.
    """
    from stability.statics.equilibrium import falling_motion  # noqa: PLC0415 -- it brings numpy

    parts = {frozenset(structure.with_all_above([name])) for name in doubted}
    own = frozenset(structure.with_all_above([first]))
    small_enough = [part for part in parts if len(part) <= (most if part == own else LITTLE)]
    for part in sorted(small_enough, key=lambda part: (len(part), sorted(part))):
        problem = structure.problem(sorted(part), structure.contacts_of(sorted(part)))
        if len(part) == 1 and lies_over(problem.bricks, problem.contacts):
            continue
        motion = falling_motion(problem, structure.tolerances)
        if motion is not None:
            return problem, motion
    return None


def fall_of(structure: Structure, brick: BodyId) -> Fall | None:
    """Return the fall of a brick and all that it can carry as one body, if plain arithmetic confirms it."""
    return fall_as_one(structure, structure.with_all_above([brick]))


def fall_on_top(structure: Structure, bricks: Collection[BodyId]) -> Fall | None:
    """Return the smallest upper part of falling bricks that falls as one body.

    Upper parts are the whole, and the bricks above one brick, with or without this brick.
    """
    if len(bricks) > CUT:
        return None
    above = {frozenset(bricks)} | {frozenset(structure.with_all_above([name])) for name in bricks}
    above |= {frozenset(structure.with_all_above(structure.carried[name])) for name in bricks}
    parts = sorted((part for part in above if part and part <= set(bricks)), key=lambda part: (len(part), min(part)))
    return next((fall for part in parts if (fall := fall_as_one(structure, part)) is not None), None)


def fall_as_one(structure: Structure, moving: Set[BodyId]) -> Fall | None:
    bricks = {name: structure.bricks[name] for name in moving}
    contacts = structure.contacts_of(sorted(moving))
    fall = tipping(bricks, [c for c in contacts if (c.lower in moving) != (c.upper in moving)])
    if fall is None:
        return None
    from stability.statics.proof import check_motion  # noqa: PLC0415 -- it brings numpy

    checked = check_motion(structure.problem(fall.bricks, contacts), fall.motion, structure.tolerances)
    return fall if checked.holds else None


# The cascade: the cheapest test with a proof decides.
#
# A brick without a proof is judged together with a group: itself, the bricks that it can carry, then step by step the
# bricks below with those that they can carry. Loads may leave the group into load cores of the bricks below, so a
# balanced group is proven independently of its supports. A group that cannot balance with all other bricks held fixed
# is proven to fall. If neither is shown, a larger group is judged, up to all connected bricks.
#
# Proof checks and solvers are imported at their first use: they import numpy, which takes longer to load than most
# scenes take to judge, and bricks on load cores need neither.


SPREAD = 4  # factor on levels, or bricks, each time a group grows
SEARCHED = 300  # bricks: up to this size of a tipping body the smallest part that tips by itself is searched
TOLD = 20  # moving bricks that are tested for an overlap, for the reason of a verdict
SMALL = 60  # bricks: up to this size a program is cheap
MOST_REFINEMENTS = 2  # of contacts with round borders; one is enough if nothing else changes
MUCH_LESS = 0.5  # share of a group, or of all connected bricks: only a smaller group is judged first


@dataclass(frozen=True, slots=True)
class StageAnswer:
    """Result of the cascade for a brick: the group that proves it, or a verdict other than STABLE."""

    group: ProofGroup | None = None
    verdict: Verdict | None = None


@dataclass(frozen=True, slots=True)
class _Falling:
    """Group that cannot balance, and a motion that proves it, possibly with more bricks than needed."""

    problem: Problem
    motion: Motion


def judge(
    structure: Structure, brick: BodyId, partners: "Partners", names_smallest: bool, doubted: Collection[BodyId]
) -> StageAnswer:
    """Prove that a brick stands or that something falls, or return the reason why neither is proven.

    With `names_smallest` the verdict names the smallest falling set that is found; falls of one of the `doubted`
    bricks, which have no proof, are searched first. Round borders get more corners as long as this may decide.
    """
    answer = _judged(structure, brick, partners, names_smallest, doubted)
    for _ in range(MOST_REFINEMENTS):
        if not _is_in_doubt(answer) or not _refined(structure, brick):
            break
        answer = _judged(structure, brick, partners, names_smallest, doubted)
    return answer


def _is_in_doubt(answer: StageAnswer) -> bool:
    return answer.verdict is not None and answer.verdict.stability is Stability.UNDECIDED


def _refined(structure: Structure, brick: BodyId) -> bool:
    """Add corners to the round borders around a brick; return whether there are new ones."""
    group = sorted(structure.component(brick))
    contacts = structure.contacts_of(group)
    if all(contact.patch is None for contact in contacts):
        return False
    from stability.statics.round_borders import refined  # noqa: PLC0415 -- it brings numpy

    found = refined(structure.problem(group, contacts), structure.tolerances)
    structure.refine(found)
    return bool(found)


def _judged(
    structure: Structure, brick: BodyId, partners: "Partners", names_smallest: bool, doubted: Collection[BodyId]
) -> StageAnswer:
    if structure.may_roll(brick):
        answer = _cones(structure, sorted(partners.of(structure.component(brick))), last=True)
        if isinstance(answer, _Falling):
            return _falls(structure, answer, names_smallest)
        assert answer is not None  # of the last group
        return _held_from_rolling(structure, answer)
    if structure.is_joined() or structure.is_pushed(brick):
        answer = _cones(structure, sorted(partners.of(structure.component(brick))), last=True)
        return _falls(structure, answer, names_smallest) if isinstance(answer, _Falling) else answer or StageAnswer()
    fallen = _tips(structure, brick)
    if fallen is not None:
        return fallen
    group, levels = partners.of({brick}), 1
    while True:
        passed = _passed_down(structure, group)
        if isinstance(passed, StageAnswer):
            return passed
        if passed is None or not passed.hinders:
            break
        group, levels = partners.of(_grown(structure, group, passed.hinders, levels)), levels * SPREAD
    if names_smallest and (whole := len(partners.of({brick} | structure.below([brick])))) > LITTLE:
        little = small_fall(structure, doubted, brick, int(MUCH_LESS * whole))
        if little is not None:
            return _falls(structure, _Falling(*little), names_smallest)
    answer = _programs(structure, brick, group, partners)
    return answer if isinstance(answer, StageAnswer) else _falls(structure, answer, names_smallest)


def prove_together(structure: Structure, bricks: Collection[BodyId], partners: "Partners") -> ProofGroup | None:
    """Prove several bricks in one program; judged one by one, the group of each would contain most of the others."""
    group = partners.of(set(bricks) | structure.below(bricks))
    return _with_next_above(structure, bricks, partners, len(group)) or _proven(structure, sorted(group))


def _with_next_above(
    structure: Structure, bricks: Collection[BodyId], partners: "Partners", whole: int
) -> ProofGroup | None:
    """Prove the same with only those counterweights that lie directly on the bricks, if this is much less work.

    Bricks above these are proven by unchanged cores, so they need no place in the group.
    """
    next_above = {upper for brick in bricks for upper in structure.carried[brick]}
    group = partners.with_partners({*bricks, *structure.below(bricks), *next_above})
    return upright_group(structure, sorted(group)) if len(group) <= MUCH_LESS * whole else None


def _proven(structure: Structure, group: Sequence[BodyId]) -> ProofGroup | None:
    return upright_group(structure, group) or _proven_in_cones(structure, group).group


def _grown(structure: Structure, group: set[BodyId], downwards: Collection[BodyId], levels: int) -> set[BodyId]:
    """Return a group extended by some bricks below it and by a number of levels of bricks below these."""
    larger = group.union(downwards)
    front = set(downwards)
    for _ in range(levels - 1):
        front = structure.below(front)
        larger |= front
    return larger


def _programs(structure: Structure, brick: BodyId, group: set[BodyId], partners: "Partners") -> StageAnswer | _Falling:
    """Run the stages that need a solver, on groups that grow from a brick up to all connected bricks."""
    whole = partners.of(structure.component(brick))
    current = partners.of({brick} | structure.below([brick]))
    while True:
        last = len(current) >= len(whole)
        members = sorted(current)
        standing = upright_group(structure, members)
        answer = StageAnswer(standing) if standing is not None else _cones(structure, members, last)
        if answer is not None:
            return answer
        if len(current) < len(group) <= SMALL:
            current = current | group
        else:
            current = partners.of(structure.spread(current, at_least=max(SMALL, SPREAD * len(current))))
        if len(current) > MUCH_LESS * len(whole):
            # a group with nearly all bricks costs as much as all, and its restriction to cores may be indecisive
            current = whole


@dataclass(frozen=True, slots=True)
class Partners:
    """Extends a group by the bricks that were proven together with one of its bricks."""

    structure: Structure
    with_partners: Callable[[Collection[BodyId]], set[BodyId]]

    def of(self, group: set[BodyId]) -> set[BodyId]:
        """Return the least group of these bricks, those they were proven with, and the bricks that these can carry."""
        while True:
            larger = self.structure.with_all_above(self.with_partners(group))
            if len(larger) == len(group):
                return larger
            group = larger


# --- tipping ----------------------------------------------------------------------------------------------------------


def _tips(structure: Structure, brick: BodyId) -> StageAnswer | None:
    """Prove that a brick, or a smaller part of its load, tips as one body with all above it; None if it does not."""
    fall = fall_of(structure, brick)
    if fall is None:
        return None
    if 1 < len(fall.bricks) <= SEARCHED:
        fall = next((f for f in _smaller_falls(structure, fall) if f is not None), fall)
    reason = _reason(structure, structure.problem(fall.bricks, structure.contacts_of(fall.bricks)), fall.motion)
    return StageAnswer(verdict=Verdict(Stability.UNSTABLE, Stage.TIPPING, reason, fall.bricks, fall.motion))


def _reason(structure: Structure, problem: Problem, motion: Motion) -> str:
    """Return the moving bricks and their motion in words; note an unsupported brick that overlaps a body."""
    loose = [name for name in sorted(motion.velocity)[:TOLD] if not structure.supports[name]]
    overlaps = [text for name in loose if (text := overlap_in_words(structure, name))]
    return "; ".join([described(problem, motion), *overlaps[:1]])


def _smaller_falls(structure: Structure, fall: Fall) -> Iterator[Fall | None]:
    """Yield the falls of parts of a tipping group, the smallest part first, ties by name."""
    parts = sorted((len(structure.with_all_above([name])), name) for name in fall.bricks)
    return (fall_of(structure, name) for size, name in parts if size < len(fall.bricks))


# --- weight propagation -----------------------------------------------------------------------------------------------


def _passed_down(structure: Structure, group: set[BodyId]) -> StageAnswer | Failure | None:
    order = from_the_top(structure.rests_on(group))
    if len(order) < len(group):
        return None  # bricks that rest on one another in a ring
    weights = {name: structure.weights[name] for name in order}
    passed = propagate(order, weights, structure.supports, structure.cores)
    if not isinstance(passed, Failure):
        return StageAnswer(ProofGroup(tuple(order), Stage.PROPAGATION, vertical=passed))
    return _tips(structure, passed.brick) or passed


# --- programs -------------------------------------------------------------------------------------------------------


def _cones(structure: Structure, group: Sequence[BodyId], last: bool) -> StageAnswer | _Falling | None:
    """Judge a group by its exact equilibrium: it stands on cores, or falls even with all other bricks fixed."""
    from stability.statics.equilibrium import balance, falling_motion  # noqa: PLC0415 -- it brings numpy

    members, contacts = frozenset(group), structure.contacts_of(group)
    fixed = structure.problem(group, contacts)  # all other bricks held fixed: an upper bound on the support
    # For a group that leans on others only a fall is tested: forces on bricks held fixed would prove nothing.
    alone = all(_is_within(contact, members, structure) for contact in contacts)
    optimistic = balance(fixed, structure.tolerances) if alone else None
    motion = optimistic.motion if optimistic is not None else falling_motion(fixed, structure.tolerances)
    if motion is not None:
        return _Falling(fixed.part(motion.velocity) if fixed.has_joints else fixed, motion)
    careful = _proven_in_cones(structure, group, optimistic)
    if careful.group is not None:
        return StageAnswer(careful.group)
    return _in_doubt(structure, careful) if last else None


def _held_from_rolling(structure: Structure, answer: StageAnswer) -> StageAnswer:
    """Return the result for a group with curved contacts: undecided if it is balanced but may roll."""
    from stability.statics.rolling import rolls_freely  # noqa: PLC0415 -- it brings numpy

    if answer.group is None:
        return answer
    members = answer.group.members
    contacts = structure.contacts_of(members)
    if not rolls_freely(structure.problem(members, contacts), structure.tolerances):
        return answer
    on_curves = {body for contact in contacts if contact.rolling for body in (contact.lower, contact.upper)}
    rolling = tuple(sorted(on_curves & set(members)))
    reason = f"{names_text(rolling)} may roll: the forces balance, but nothing holds every round contact in its place"
    return StageAnswer(verdict=Verdict(Stability.UNDECIDED, Stage.CONES, reason, rolling))


@dataclass(frozen=True, slots=True)
class _Careful:
    """Result for a group that may lean on other bricks only at load cores."""

    problem: Problem
    balance: "Balance"
    group: ProofGroup | None = None  # None unless the group is proven to stand


def _proven_in_cones(structure: Structure, group: Sequence[BodyId], if_fixed: "Balance | None" = None) -> _Careful:
    """Prove that a group stands on load cores; `if_fixed` is its balance with all other bricks fixed, if known."""
    from stability.statics.equilibrium import balance  # noqa: PLC0415 -- it brings numpy
    from stability.statics.self_stress import forces_without_self_stress  # noqa: PLC0415 -- it brings numpy

    members, contacts = frozenset(group), structure.contacts_of(group)
    inner = [c for c in contacts if _is_within(c, members, structure)]
    outer = [c for c in contacts if not _is_within(c, members, structure) and carries_upright(c)]
    landings = list(landings_of(structure, members, outer))
    # the problem is then the same as with all other bricks held fixed
    alone = not landings and len(inner) == len(contacts)
    problem = structure.problem(group, contacts if alone else [*inner, *(landing for landing, _ in landings)])
    answer = if_fixed if alone and if_fixed is not None else balance(problem, structure.tolerances)
    honest = answer.forces
    if honest is not None and not answer.frictionless:
        honest = forces_without_self_stress(problem, honest, structure.tolerances)
    if honest is None:
        return _Careful(problem, answer)
    of_inner, of_outer = honest.of_contacts[: len(inner)], honest.of_contacts[len(inner) :]
    forces, vertical = tuple(zip(inner, of_inner, strict=True)), vertical_forces(of_outer, landings)
    return _Careful(problem, answer, ProofGroup(tuple(group), Stage.CONES, vertical=vertical, forces=forces))


def _is_within(contact: Contact, members: Collection[BodyId], structure: Structure) -> bool:
    """Return whether both bodies of a contact belong to the group or one is fixed."""
    return all(body in members or body not in structure.bricks for body in (contact.lower, contact.upper))


def _falls(structure: Structure, falling: _Falling, names_smallest: bool) -> StageAnswer:
    from stability.statics.mechanism import smallest_mechanism  # noqa: PLC0415 -- it brings numpy

    problem, least = falling.problem, falling.motion
    if names_smallest:
        whole = fall_on_top(structure, least.velocity.keys())
        least = whole.motion if whole is not None else smallest_mechanism(problem, least, structure.tolerances)
    reason = _reason(structure, problem, least)
    return StageAnswer(verdict=Verdict(Stability.UNSTABLE, Stage.CONES, reason, tuple(sorted(least.velocity)), least))


def _in_doubt(structure: Structure, careful: _Careful) -> StageAnswer:
    from stability.statics.initial_motion import find_start  # noqa: PLC0415 -- it brings numpy

    problem, balance = careful.problem, careful.balance
    if balance.forces is not None:
        reason = "only self-stress can hold the structure: contact forces that the weights do not require"
        start = find_start(problem, structure.tolerances)
        if start is not None:
            reason += f"; without these forces, {described(problem, start.acceleration)}"
    else:
        reason = f"too close to the limit of stability for a proof in either direction ({balance.note})"
    return StageAnswer(verdict=Verdict(Stability.UNDECIDED, Stage.CONES, reason, tuple(problem.bricks)))
