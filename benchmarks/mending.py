"""Verifies single pulls from towers and remedies of random piles by independent linear programs.

Jenga towers of 18 levels, complete and thinned out, blocks side by side and with gaps: every single pull, with its
time. 100 random falling piles of boxes for each of some seeds: each remedy of `stackdsl suggest` is tested by a linear
program at its full amount and at a slightly smaller one. Run it with `python -m benchmarks.mending`; ten minutes.
"""

import random
import sys
from collections.abc import Sequence
from itertools import islice
from statistics import median
from time import process_time

from rich.console import Console
from rich.progress import track

from benchmarks.equilibrium_programs import answer
from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from benchmarks.random_piles import MENDING, Checked, Mended, mended, piles, upright
from stability.analysis.removal_order import carrying, longest_order, single_pulls, soonest_fall
from stability.analysis.subset_search import Subsets
from stability.geometry.box import Box
from stability.model import Brick, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly

BLOCK = (0.075, 0.025, 0.015)  # [m]
FRICTION = 0.5
GAP = 0.001  # [m] between blocks side by side


def jenga(levels: int, gap: float = 0.0) -> list[Placed]:
    """Return a tower of three blocks per level, each level across the one below."""
    length, width, thickness = BLOCK
    blocks = []
    for level in range(levels):
        for number in range(3):
            aside, height = (number - 1) * width, (level + 0.5) * thickness
            size = (length, width - gap, thickness) if level % 2 == 0 else (width - gap, length, thickness)
            at = (0.0, aside, height) if level % 2 == 0 else (aside, 0.0, height)
            blocks.append(Placed(Brick(f"L{level + 1}.{number + 1}", Box(size), 0.02), Pose(at)))
    return blocks


def thinned(levels: int, seed: int) -> Assembly:
    """Return a tower with gaps, minus a third of its blocks, each pulled while the rest stood."""
    draw = random.Random(seed)
    design = Assembly()
    design.add_all(jenga(levels, GAP))
    names = sorted(carrying(design))
    draw.shuffle(names)
    for name in names[: len(names) // 2]:
        tried = design.copied()
        if tried.remove([name]).stability is Stability.STABLE:
            design = tried
    return design


def pulls(design: Assembly) -> dict[str, float | int]:
    """Pull every single brick of a tower, and count the verdicts that a linear program confirms."""
    started = process_time()
    pulls_judged = list(single_pulls(design))
    spent = process_time() - started
    wrong = open_ = 0
    for pull in pulls_judged:
        rest = [upright(placed) for name, placed in design.bricks.items() if name != pull.brick]
        truth = answer(rest, FRICTION)
        open_ += truth is None
        stability = pull.verdict.stability
        wrong += truth is not None and stability is not (Stability.STABLE if truth else Stability.UNSTABLE)
    stands = sum(pull.verdict.stability is Stability.STABLE for pull in pulls_judged)
    falls = sum(pull.verdict.stability is Stability.UNSTABLE for pull in pulls_judged)
    parts = Subsets(design)
    may_go = parts.part_of(carrying(design))
    started = process_time()
    longest, soonest = longest_order(parts, may_go, 5000), soonest_fall(parts, may_go, 5000)
    return {
        "pulls": len(pulls_judged),
        "stand": stands,
        "fall": falls,
        "wrong": wrong,
        "not_said": open_,
        "pull_ms": 1e3 * spent / len(pulls_judged),
        "longest": len(longest.order),
        "at_most": longest.at_most,
        "soonest": len(soonest.order),
        "orders_s": process_time() - started,
    }


def main() -> None:
    """Measure and print the tables; write them on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--piles", type=int, default=100, help="of each seed")
    arguments.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    chosen = arguments.parse_args()
    whole, apart = Assembly(), Assembly()
    whole.add_all(jenga(18))
    apart.add_all(jenga(18, GAP))
    towers = {"18 levels, side by side": whole, "18 levels, with gaps": apart}
    towers |= {f"thinned out, seed {seed}": thinned(18, seed) for seed in range(3)}
    console = Console(stderr=True)
    of_towers: Rows = {name: pulls(tower) for name, tower in track(towers.items(), "towers", console=console)}
    drawn = {seed: islice(piles(seed), chosen.piles) for seed in chosen.seeds}
    mended_piles = {
        seed: [mended(pile) for pile in track(each, f"piles of seed {seed}", chosen.piles, console=console)]
        for seed, each in drawn.items()
    }
    of_seeds: Rows = {f"seed {seed}": _mended(each) for seed, each in mended_piles.items()}
    every = [one for each in mended_piles.values() for one in each]
    kinds = {kind: [one for mending in every for one in mending.checked if one.kind == kind] for kind in MENDING}
    of_kinds: Rows = {kind: _told(each) for kind, each in kinds.items()}
    console.print(of_towers, of_seeds, of_kinds)
    if chosen.write:
        tables = {"pulls": of_towers, "piles": of_seeds, "remedies": of_kinds}
        record("mending", " ".join(["python -m benchmarks.mending", *sys.argv[1:]]), tables)


def _mended(piles: Sequence[Mended]) -> Row:
    """Return the number of repaired piles, by kind of remedy, the cheapest first."""
    hows = {kind.replace(" ", "_"): sum(one.how == kind for one in piles) for kind in (*MENDING, "nothing")}
    verified = sum(any(each.whole and each.stands and each.falls_with_less for each in one.checked) for one in piles)
    return {
        "piles": len(piles),
        "mended": sum(one.how != "nothing" for one in piles),
        "verified": verified,
        **hows,
        "median_s": median(one.seconds for one in piles),
        "worst_s": max(one.seconds for one in piles),
    }


def _told(suggestions: Sequence[Checked]) -> Row:
    """Return the verdicts of linear programs on all suggestions of a kind."""
    return {
        "told": len(suggestions),
        "of_all": sum(one.whole for one in suggestions),
        "stand": sum(one.stands is True for one in suggestions),
        "fall": sum(one.stands is False for one in suggestions),
        "not_said": sum(one.stands is None for one in suggestions),
        "fall_with_less": sum(one.falls_with_less for one in suggestions),
    }


if __name__ == "__main__":
    main()
