"""Limits the work of one case. The estimate counts bricks and steps, so it is the same on every machine.

A few lines can ask for hours and for all the memory there is, such as a margin of 1,600 bricks at once. What is beyond
is refused before it begins, with its place in the file. Whoever runs the command may allow more, never the file itself.
"""

import os
from math import isfinite
from typing import Final

VARIABLE: Final = "STACKDSL_WORK"  # of the environment: so many times as much as by default is allowed
MOST_STEPS: Final = 400_000  # units of a run on exact: one for each moving brick in each step of the engine
MOST_STEPS_BARE: Final = 4_000_000  # the same where nothing is proven meanwhile, which takes a tenth as long
STEP, STEP_BARE = 20, 1  # units of a step, however few bricks move in it; most is what is asked of an extension
AHEAD: Final = 1.0  # [s] that what moves goes on for at least, as far as is known: so long a fall is followed
# Bricks in one program of a margin; what it takes grows with their square, and with their third power.
MOST_BRICKS: Final = {"placement": 200, "acceleration": 600, "tilt": 600}
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
    most = MOST_BRICKS.get(margin)
    return None if most is None else int(most * allowed() ** 0.5)
