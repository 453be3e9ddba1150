"""Limits the work of one case. The estimate counts bricks and steps, so it is the same on every machine.

A few lines can ask for hours and for all the memory there is, such as a margin of 1,600 bricks at once. What is beyond
is refused before it begins, with its place in the file. Whoever runs the command may allow more, never the file itself.
"""

import os
from collections.abc import Mapping
from math import isfinite
from typing import Final

VARIABLE: Final = "STACKDSL_WORK"  # of the environment: so many times as much as by default is allowed
MOST_STEPS: Final = 400_000  # units of a run on exact: one for each moving brick in each step of the engine
MOST_STEPS_BARE: Final = 4_000_000  # the same where nothing is proven meanwhile, which takes a tenth as long
# What is no step of an engine comes to so many units on exact, measured beside those of its steps.
SPLIT: Final = 0.6  # a part of a step that is split because something is fast
SPLIT_MOVING: Final = 0.3  # and each brick that moves in it
KNOWN: Final = 2.0  # a step of a motion that is known without an engine
LOOK: Final = 6.0  # a look at a brick that a hand moves
LANDING: Final = 8.0  # a brick that is taken into the proof that what drops stops where it lands
STEP, STEP_BARE = 20, 1  # units of a step, however few bricks move in it; most is what is asked of an extension
AHEAD: Final = 1.0  # [s] that what moves goes on for at least, as far as is known: so long a fall is followed
# Bricks in one program of a margin; what it takes grows with their square, and with their third power.
MOST_BRICKS: Final = {"placement": 200, "acceleration": 600, "tilt": 600}
# Pairs of bricks in it that may touch: in a wall two or three for each brick, in a lattice of n levels of n bars n.
MOST_PAIRS: Final = {"placement": 1400, "acceleration": 3000, "tilt": 3000}
HINT: Final = f"or allow more by {VARIABLE}, as of 4 for four times as much"


class WorkError(ValueError):
    """The variable says what is no number."""


def allowed() -> float:
    """How many times as much as by default is allowed. Raises WorkError."""
    said = os.environ.get(VARIABLE, "1")
    try:
        times = float(said)
    except ValueError:
        times = 0.0
    if not (times > 0.0 and isfinite(times) and said.isascii()):
        raise WorkError(f"{VARIABLE} is {said!r}; write how many times as much as by default is allowed, such as 4")
    return times


def most_bricks(margin: str) -> int | None:
    """How many bricks a claim of a margin may be about; None where it is cheap."""
    return _most(MOST_BRICKS, margin)


def most_pairs(margin: str) -> int | None:
    """How many pairs of bricks may touch where a claim of a margin is about them; None where it is cheap."""
    return _most(MOST_PAIRS, margin)


def _most(by_margin: Mapping[str, int], margin: str) -> int | None:
    most = by_margin.get(margin)
    return None if most is None else int(most * allowed() ** 0.5)
