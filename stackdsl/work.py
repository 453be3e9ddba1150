"""Limits the work of one case. The estimate counts bricks, steps and proofs, so it is the same on every machine.

A few lines of YAML can need hours and all memory, such as a margin of 1,600 bricks at once. Work beyond the limit is
refused before it begins, with its place in the file. The user of the command can raise the limit; the file cannot.
"""

import os
from collections.abc import Mapping
from math import isfinite
from typing import Final

from stability.work_limit import WorkLimit

VARIABLE: Final = "STACKDSL_WORK"  # environment variable: factor on the default limit
MOST_STEPS: Final = 2_000_000  # units of a run on exact: one for each moving brick in each step of the engine
STEP_WORK: Final = 50.0  # units of `stability.work_limit` in one unit of a run
MOST_WORK: Final = 40_000_000.0  # units of `stability.work_limit` of the proofs of a run, or of a command on one case
LARGEST: Final = 600_000  # entries of one matrix; a proof with a larger one takes more than 500 MB
MOST_STEPS_BARE: Final = 20_000_000  # units of a run without proofs, which takes a tenth of the time
# Costs on exact besides the steps of the engine, measured in units of such a step.
SPLIT: Final = 0.6  # one sub-step of a step that is split because of a fast brick
SPLIT_MOVING: Final = 0.3  # each brick that moves in a sub-step
KNOWN: Final = 2.0  # a step of a closed-form motion, without the engine
LOOK: Final = 6.0  # one check of a brick that a hand moves
LANDING: Final = 8.0  # a brick in the proof that a dropped brick stops where it lands
STEP, STEP_BARE = 20, 1  # units of a step without moving bricks; most of it is the interface to the engine
AHEAD: Final = 1.0  # [s] least time for which motion is assumed to go on: a fall is followed for so long
# Bricks in the linear program of one margin; its time grows with their square to third power.
MOST_BRICKS: Final = {"placement": 200, "acceleration": 600, "tilt": 600, "load on all bricks": 200}
# Points in it at which bricks may touch: four per pair of boxes, with two or three pairs per brick in a wall and n in a
# lattice of n levels of n bars. Its matrices have rows for each point.
MOST_POINTS: Final = {"placement": 5600, "acceleration": 5000, "tilt": 5000}
HINT: Final = f"or allow more work, for example with {VARIABLE}=4"


class WorkError(ValueError):
    """The environment variable `STACKDSL_WORK` is not a positive number."""


def work_factor() -> float:
    """Return the factor on the default limits of work. Raises WorkError."""
    text = os.environ.get(VARIABLE, "1")
    try:
        factor = float(text)
    except ValueError:
        factor = 0.0
    if not (factor > 0.0 and isfinite(factor) and text.isascii()):
        raise WorkError(f"{VARIABLE} is {text!r}; write a factor on the default limit, such as 4")
    return factor


def limit() -> WorkLimit:
    """Return the limit on the work of proofs."""
    return WorkLimit(MOST_WORK * work_factor(), LARGEST * work_factor())


def most_bricks(margin: str) -> int | None:
    """Return the most bricks in a claim on a margin; None for margins that are cheap to compute."""
    return _most(MOST_BRICKS, margin)


def most_points(margin: str) -> int | None:
    """Return the most contact points in a claim on a margin; None for margins that are cheap to compute."""
    return _most(MOST_POINTS, margin)


def _most(by_margin: Mapping[str, int], margin: str) -> int | None:
    most = by_margin.get(margin)
    return None if most is None else int(most * work_factor() ** 0.5)
