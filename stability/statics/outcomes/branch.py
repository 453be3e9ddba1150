"""Branches of a case distinction over how points of contact start: together they leave nothing out.

A point opens, and then no force acts there, or it stays shut. What slides there does so to one side of a line or to the
other; rest and the line itself belong to both.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TypeAlias

import numpy as np

from stability.model import Vec3
from stability.statics.outcomes.start_equations import Array, StartEquations

SHUT = 1e-9  # share of the largest: a combination of normal accelerations that is less is taken to be free


class How(StrEnum):
    """What is taken to be so at a point."""

    OPENS = "opens"  # the normal acceleration is not negative, and no force acts
    SHUT = "stays shut"  # the normal acceleration is nothing
    TOWARDS = "goes towards"  # the relative acceleration has no part against a direction


@dataclass(frozen=True, slots=True)
class Condition:
    """One answer to one question; the other answer is its `opposite`."""

    point: int
    how: How
    towards: Vec3 = (0.0, 0.0, 0.0)  # of TOWARDS, in W

    @property
    def opposite(self) -> "Condition":
        """What is so if this is not."""
        if self.how is How.TOWARDS:
            x, y, z = self.towards
            return Condition(self.point, How.TOWARDS, (-x, -y, -z))
        return Condition(self.point, How.SHUT if self.how is How.OPENS else How.OPENS)


Branch: TypeAlias = tuple[Condition, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """What is known of accelerations in a branch: they are `basis @ b`, and none of `rows @ b` is negative."""

    basis: Array  # (D, d)
    rows: Array  # (l, d)
    owners: tuple[int, ...]  # of each row the point whose normal acceleration it is; -1 for any other
    pressed: tuple[int, ...]  # the points at which forces may act


def known(equations: StartEquations, branch: Branch) -> Known:
    """What is known in a branch: the last row says that the loads gain, without which nothing starts from rest."""
    single = [point for point, normals in enumerate(equations.normals) if len(normals) == 1]
    shut = [each.point for each in branch if each.how is How.SHUT]
    opened = {each.point for each in branch if each.how is How.OPENS}
    basis = _free(equations, shut)
    opening = {point: equations.axes[point, 0] @ equations.slips[point] @ basis for point in single}
    owners = [point for point in single if point not in shut and np.abs(opening[point]).max(initial=0.0) > SHUT]
    sides = [np.array(each.towards) @ equations.slips[each.point] @ basis for each in branch if each.how is How.TOWARDS]
    return Known(
        basis,
        np.array([*(opening[point] for point in owners), *sides, equations.loads @ basis]),
        (*owners, *(-1 for _ in sides), -1),
        tuple(point for point in range(len(equations.normals)) if point not in opened),
    )


def _free(equations: StartEquations, shut: Sequence[int]) -> Array:
    """An orthonormal basis of the accelerations at which these points stay shut; a larger space if in doubt."""
    if not shut:
        return np.identity(len(equations.loads))
    rows = np.array([equations.axes[point, 0] @ equations.slips[point] for point in shut])
    _, sizes, turned = np.linalg.svd(rows)
    basis: Array = turned[int((sizes > SHUT * sizes[0]).sum()) :].T
    return basis


def leave_nothing_out(branches: Sequence[Branch], depth: int = 0) -> bool:
    """Whether branches are all ends of one tree of questions, so that everything that can be is in one of them."""
    if len(branches) == 1 and len(branches[0]) == depth:
        return True
    if not branches or any(len(branch) <= depth for branch in branches):
        return False
    first = branches[0][depth]
    one = [branch for branch in branches if branch[depth] == first]
    other = [branch for branch in branches if branch[depth] == first.opposite]
    both = len(one) + len(other) == len(branches)
    return both and leave_nothing_out(one, depth + 1) and leave_nothing_out(other, depth + 1)
