"""Falls of the upper part of an assembly: of some bricks and all that they carry, while the rest is held fixed."""

from collections.abc import Collection, Set

from stability.model import BodyId
from stability.statics.facts import Motion, Problem
from stability.statics.structure import Structure
from stability.statics.tipping import Fall, lies_over, tipping

CUT = 60  # bricks: in a falling group up to this size the smallest upper part that falls as one body is looked for
LITTLE = 8  # bricks: a program of so few costs about as much as writing it down


def little_fall(
    structure: Structure, doubted: Collection[BodyId], first: BodyId, most: int
) -> tuple[Problem, Motion] | None:
    """A fall of few bricks: of one of the doubted and all that it carries; its problem, and a motion that proves it.

    In a load that falls, most often little falls at first. To find that costs less than to judge the whole. Of the
    `first`, what it carries may be up to so many bricks.
    """
    from stability.statics.solvers.equilibrium import falling_motion  # noqa: PLC0415 -- it brings numpy

    parts = {frozenset(structure.with_all_above([name])) for name in doubted}
    own = frozenset(structure.with_all_above([first]))
    asked = [part for part in parts if len(part) <= (most if part == own else LITTLE)]
    for part in sorted(asked, key=lambda part: (len(part), sorted(part))):
        problem = structure.problem(sorted(part), structure.contacts_of(sorted(part)))
        if len(part) == 1 and lies_over(problem.bricks, problem.contacts):
            continue
        motion = falling_motion(problem, structure.tolerances)
        if motion is not None:
            return problem, motion
    return None


def fall_of(structure: Structure, brick: BodyId) -> Fall | None:
    """The fall of a brick and all that it can carry as one body, if plain arithmetic agrees."""
    return fall_as_one(structure, structure.with_all_above([brick]))


def fall_on_top(structure: Structure, bricks: Collection[BodyId]) -> Fall | None:
    """The smallest upper part of falling bricks that falls as one body: all, or those above one, with it or without."""
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
