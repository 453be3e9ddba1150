"""The smallest set of bricks that meets every clause: at least one of these there, or one of those not.

An integer program (HiGHS, by way of scipy). What it says is least is a bound only as far as its search went.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

MOST_NODES = 2_000  # of the search: seconds
TIE = 1e-6  # by which an earlier brick is preferred to a later one, so that the answer is always the same
SLACK = 1e-3  # of the objective, more than all ties together


@dataclass(frozen=True, slots=True)
class Clause:
    """At least one brick of `there` must be in the set, or one of `away` not."""

    there: int  # bits
    away: int = 0

    def met_by(self, chosen: int) -> bool:
        """Whether a set of bricks meets it."""
        return bool(chosen & self.there or self.away & ~chosen)


@dataclass(frozen=True, slots=True)
class Smallest:
    """A set that meets all clauses; `None` if there is none."""

    chosen: int | None
    at_least: int  # bricks in every set that does, proven by the search


def smallest(bits: int, clauses: Sequence[Clause], most_nodes: int = MOST_NODES) -> Smallest:
    """The smallest set out of so many bricks."""
    import numpy as np  # noqa: PLC0415 -- they take longer to load than most verdicts to find
    from scipy.optimize import Bounds, LinearConstraint, milp  # noqa: PLC0415 -- likewise
    from scipy.sparse import csr_matrix  # noqa: PLC0415 -- likewise

    if not clauses:
        return Smallest(0, 0)
    rows, columns, values, least = [], [], [], []
    for row, clause in enumerate(clauses):
        for bit in range(bits):
            sign = (clause.there >> bit & 1) - (clause.away >> bit & 1)
            if sign:
                rows.append(row)
                columns.append(bit)
                values.append(float(sign))
        least.append(1.0 - clause.away.bit_count())
    matrix = csr_matrix((values, (rows, columns)), shape=(len(clauses), bits))
    tie = min(TIE, 0.1 * SLACK / max(1, bits * bits))
    found = milp(
        1.0 + tie * np.arange(bits),
        constraints=LinearConstraint(matrix, np.array(least), np.inf),
        integrality=np.ones(bits),
        bounds=Bounds(0.0, 1.0),
        options={"node_limit": most_nodes, "mip_rel_gap": 0.0},
    )
    bound = found.mip_dual_bound
    at_least = max(0, ceil(bound - SLACK)) if bound is not None and np.isfinite(bound) else 0
    if found.x is None:
        return Smallest(None, at_least)
    chosen = sum(1 << bit for bit in range(bits) if found.x[bit] > 0.5)  # noqa: PLR2004 -- either 0 or 1
    return Smallest(chosen if all(clause.met_by(chosen) for clause in clauses) else None, at_least)
