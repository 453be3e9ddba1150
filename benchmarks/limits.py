"""Compares the least friction of leaning planks on the bare engine with the closed form.

An inverted V, and a plank on a smooth wall, stand if mu is at least (cot a - t / L) / 2 (Coulomb friction, edge
contacts). The limit is found by bisection of the reported result: a collapse, or none. It is the same for all sizes and
in all directions; `tuned` is tested in some. Run it with `python -m benchmarks.limits`; about five minutes.
"""

import sys
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from math import atan, degrees, sqrt

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from benchmarks.slips import KAPLA, Case, timeline
from stability.model import Vec3
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import MOVING, SYSTEMS, System

ANGLES = (50.0, 60.0, 70.0, 75.0, 80.0, 82.0)  # to the floor [deg]
LENGTHS = (0.01, 0.03, KAPLA[0], 0.2, 1.2)  # of planks [m]
YAWS = (0.0, 15.0, 22.5, 30.0, 45.0, 75.0)  # [deg]
WATCHED = 2.0  # [s] for KAPLA planks; large ones take longer to fall
ENGINES = {**{name: SYSTEMS[name] for name in ("tuned", "stock")}, "moving": System("moving", "", MOVING, method=None)}
LOWEST, HIGHEST, SHARP = 0.8, 1.2, 0.001  # shares of the required friction


def falls(case: Case, system: System) -> bool:
    """Return whether a collapse is reported; the run ends there."""
    watched = WATCHED * sqrt(max(1.0, case.size[0] / KAPLA[0]))
    return play(replace(timeline(case), hold=watched, aftermath=False), system).collapse is not None


def scaled(length: float) -> Vec3:
    """Return the size of a brick like a KAPLA plank, but of another length [m]."""
    scale = length / KAPLA[0]
    return (scale * KAPLA[0], scale * KAPLA[1], scale * KAPLA[2])


def limit(case: Case, system: System) -> float:
    """Return the share of the required friction from which it stands, within SHARP."""
    low, high = LOWEST, HIGHEST
    while high - low > SHARP:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if falls(replace(case, share=middle), system) else (low, middle)
    return 0.5 * (low + high)


def too_flat(case: Case, share: float) -> float:
    """Return the decrease of the limit angle in the closed form if friction is multiplied by the share [deg]."""
    length, _, thickness = case.size
    friction = replace(case, share=1.0).friction * share
    return case.angle - degrees(atan(1.0 / (2.0 * friction + thickness / length)))


def main() -> None:
    """Bisect and print the table; write it on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--system", default="tuned", choices=list(ENGINES), help="moving: that of exact, by itself")
    arguments.add_argument("--angles", type=float, nargs="+", default=list(ANGLES), help="to the floor [deg]")
    arguments.add_argument("--lengths", type=float, nargs="+", default=list(LENGTHS), help="of planks [m]")
    chosen = arguments.parse_args()
    system = ENGINES[chosen.system]
    table = Table("", "long", *(f"{angle:g} deg" for angle in chosen.angles))
    rows = list(product(("V", "ladder"), chosen.lengths))
    errors_of: dict[str, list[float]] = {"V": [], "ladder": []}
    for kind, length in track(rows, "limits", console=Console(stderr=True), transient=True):
        by_angle = [errors(kind, angle, scaled(length), system) for angle in chosen.angles]
        errors_of[kind] += [one for each in by_angle for one in each]
        table.add_row(kind, f"{100.0 * length:g} cm", *(_range(kind, each) for each in by_angle))
    Console(width=140).print("Friction from which it stands / needed (ladder: error of the angle), all yaws.", table)
    if chosen.write:
        rows_kept: Rows = {
            kind: _values(kind, of_kind, chosen.angles, chosen.lengths) for kind, of_kind in errors_of.items()
        }
        record("limits", " ".join(["python -m benchmarks.limits", *sys.argv[1:]]), {chosen.system: rows_kept})


def errors(kind: str, angle: float, size: Vec3, system: System) -> list[float]:
    """Return errors by direction.

    The error of a V is the ratio of limit and required friction; the error of a ladder is an angle [deg].
    """
    cases = [Case(kind, angle, 1.0, yaw, size) for yaw in YAWS]
    shares = [limit(case, system) for case in cases]
    return shares if kind == "V" else [too_flat(case, share) for case, share in zip(cases, shares, strict=True)]


def _range(kind: str, values: Sequence[float]) -> str:
    if kind == "V":
        return f"{min(values):.3f} .. {max(values):.3f}"
    return f"{min(values):+.2f} .. {max(values):+.2f} deg"


def _values(kind: str, values: Sequence[float], angles: Sequence[float], lengths: Sequence[float]) -> Row:
    worst = max(abs(each - 1.0) * 100.0 if kind == "V" else abs(each) for each in values)
    return {
        "least": min(values),
        "most": max(values),
        "worst_percent" if kind == "V" else "worst_deg": worst,
        "asked": len(values),
        "least_angle_deg": min(angles),
        "most_angle_deg": max(angles),
        "shortest_cm": 100.0 * min(lengths),
        "longest_cm": 100.0 * max(lengths),
    }


if __name__ == "__main__":
    main()
