"""Directions of acceleration solved roughly, in a third of the time, and proven all the same.

A solver that is asked for a share of a reach leaves forces a little outside of their cones, and motions that close
contacts a little. Forces are mended as ever. To a motion so much of one that opens every contact is added that none is
closed; how far off all accelerations lie that it then rules out is plain arithmetic: what the loads resist it by, over
its momentum.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import cos, hypot, sin

import numpy as np

from stability.statics.facts import ZERO, Motion, Wrench
from stability.statics.margins.acceleration_cut import (
    FURTHEST,
    Cut,
    Heading,
    Shaken,
    heading,
    program_along,
    proven_reach,
)
from stability.statics.solvers.conic_program import Point, QuickSeries
from stability.statics.solvers.separating_motion import separating_velocities
from stability.statics.solvers.wrench_matrix import Array

AT_ONCE = 2  # directions, whatever cores there are: which are solved next hangs on those that are known
FINEST, ROUGHEST = 1e-10, 1e-6  # accuracies that are asked of the solver
OF_TOLERANCE = 2e-5  # share of what a reach may be off by that the solver is asked for: with more, more directions
QUIET = (1e-4, 1e-9, 0.0)  # shares of the largest speed below which a brick is first taken to stay
MOST_OPENED = 0.01  # of the speed of the fastest: a motion that needs to be opened by more is no solution
SURELY = 1.0 + 1e-6  # times what is needed to open contacts, and to gain what a proof must: rounding
FURTHER = (4.0, 100.0, 1e4, 1e6)  # times the least gain of a proof, tried in turn


@dataclass(frozen=True, slots=True, eq=False)
class RoughHeadings:
    """A case, and how its directions are solved to a relative tolerance."""

    case: Shaken
    tolerance: float
    opening: Array | None  # (columns,) a motion that opens every contact; without one directions are solved finely
    series: tuple[QuickSeries, ...]  # as many directions are solved at once

    def solve(self, angle: float) -> Heading:
        """How far the assembly can be accelerated in one direction."""
        return self.solve_all([angle])[0]

    def solve_all(self, angles: Sequence[float]) -> list[Heading]:
        """The same of no more directions than may be solved at once, each on a core of its own where there is one."""
        if self.opening is None:
            return [heading(self.case, angle) for angle in angles]
        with ThreadPoolExecutor(len(angles)) as threads:  # what takes long is the solver, which lets others go on
            points = list(threads.map(self._asked, self.series, angles))
        return [self._proven(self.opening, angle, point) for angle, point in zip(angles, points, strict=True)]

    def _asked(self, series: QuickSeries, angle: float) -> Point:
        return series.solve(program_along(self.case, angle))

    def _proven(self, opening: Array, angle: float, point: Point) -> Heading:
        if not (np.isfinite(point.x).all() and np.isfinite(point.dual).all()):
            return heading(self.case, angle)
        value, columns = max(0.0, -float(point.dual[0])), point.x[:-1]
        cut = self._cut(opening, columns) if value < 0.5 * FURTHEST else None
        if cut is None:
            return heading(self.case, angle)
        reach, rows = proven_reach(self.case, (cos(angle), sin(angle)), value, point.dual[1:-1])
        share = cut.normal[0] * cos(angle) + cut.normal[1] * sin(angle)
        if share <= 0.0 or reach < (1.0 - self.tolerance) * cut.distance / share:
            return heading(self.case, angle)
        return Heading(angle, reach, rows, self.case.system.matrix @ columns, cut)

    def _cut(self, opening: Array, columns: Array) -> Cut | None:
        """The half-plane that a motion proves once it is opened."""
        for share in QUIET:
            opened = self._opened(opening, self.case.system.motion(columns, share))
            cut = proven_cut(self.case, opened) if opened is not None else None
            if cut is not None:
                return cut
        return None

    def _opened(self, opening: Array, motion: Motion) -> Motion | None:
        """A motion with as much of the opening one added, to the bricks that move, as leaves no contact closed."""
        system = self.case.system
        columns = system.columns_of(motion)
        opening = np.where(self._moves(motion), opening, 0.0)
        spare, gained = self._spare(system.matrix @ columns), self._spare(system.matrix @ opening)
        closed = spare < 0.0
        if (closed & (gained <= 0.0)).any():
            return None
        needed = SURELY * float((-spare[closed] / gained[closed]).max(initial=0.0))
        if needed > MOST_OPENED:
            return None
        return system.motion(columns + needed * opening)

    def _moves(self, motion: Motion) -> Array:
        """(columns,) which belong to a brick that moves."""
        moving: Array = np.repeat([name in motion.velocity for name in self.case.system.names], 6)
        return moving[self.case.system.kept]

    def _spare(self, slips: Array) -> Array:
        """(cones,) by how much each slip is within its cone; of two motions together it is no less than the sum."""
        held = 3 * len(self.case.system.round)
        cones = slips[:held].reshape(-1, 3)
        return np.append(cones[:, 0] - np.hypot(cones[:, 1], cones[:, 2]), slips[held:])


def rough_headings(case: Shaken, tolerance: float) -> RoughHeadings:
    """Directions of a case, solved to a relative tolerance."""
    velocities = separating_velocities(case.problem, case.problem.bricks)
    opening = None
    if velocities is not None:
        opening = case.system.columns_of(Motion({name: (velocity, ZERO) for name, velocity in velocities.items()}))
    accuracy = min(ROUGHEST, max(FINEST, OF_TOLERANCE * tolerance))
    return RoughHeadings(case, tolerance, opening, tuple(QuickSeries(accuracy) for _ in range(AT_ONCE)))


def proven_cut(case: Shaken, motion: Motion) -> Cut | None:
    """The half-plane that a motion proves, as near as it does: where it gains no more than a proof must."""
    momentum, resisted, size = _powers(case, motion)
    along = hypot(*momentum)
    if not along > 0.0:
        return None
    x, y = momentum[0] / along, momentum[1] / along
    distance = max(0.0, resisted / along)
    for times in FURTHER:
        proven = distance + times * case.tolerances.gain * size * (1.0 + distance) / along
        if case.falls(proven * x, proven * y, motion).holds:
            return Cut((x, y), proven, 0.0, motion)
    return None


def _powers(case: Shaken, motion: Motion) -> tuple[tuple[float, float], float, float]:
    """What an acceleration of 1 g along x and y gains by a motion, what loads lose, and the sum of all sizes [W]."""
    gained, resisted, size = np.zeros(2), 0.0, 0.0
    for name, (velocity, spin) in sorted(motion.velocity.items()):
        weight, load = case.weights.get(name, 0.0), case.problem.loads.get(name, Wrench(ZERO))
        gained += weight * np.array(velocity[:2])
        resisted -= float(np.dot(load.force_W, velocity) + np.dot(load.torque_W, spin))
        size += (hypot(*load.force_W) + weight) * hypot(*velocity) + hypot(*load.torque_W) * hypot(*spin)
    return (float(gained[0]), float(gained[1])), resisted, size
