"""`settle` and `pushover`: a structure whose supports move, or that its loads push over, by finite displacements."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from math import hypot, inf, pi

from stability.analysis.large_motion import LargeMotion, Position, pushover, support_path
from stability.notebook import Printed
from stability.problem import Stability
from stability.statics.fall_description import described
from stability.supports import SupportMotion
from stackdsl.checking.cases import Case
from stackdsl.judging.proofs import RIGID, TIED, proofs_of
from stackdsl.studies.limit_search import SearchError


class Pushed(StrEnum):
    """Cause of the motion of a structure."""

    SUPPORTS = "supports"
    LOADS = "loads"


@dataclass(frozen=True, slots=True)
class FollowedMotion(Printed):
    """The motion of one case by finite displacements."""

    case: str
    pushed: Pushed
    unit: str  # of movements: mm, or deg if supports only turn
    scale: float  # movement for an amount of 1, in `unit`
    weight: float  # of the structure [N]
    motion: LargeMotion
    why: str = ""  # the fall in words

    def movement(self, amount: float) -> float:
        """Return a movement in `unit`."""
        return self.scale * amount

    @staticmethod
    def thrust(position: Position) -> float:
        """Return the largest horizontal force of a support [N]."""
        return max((hypot(x, y) for x, y, _ in position.reactions_W), default=0.0)


def largest_movement(supports: tuple[SupportMotion, ...]) -> tuple[float, str]:
    """Return the largest shift of supports as written [mm], or their largest turn [deg] if none shifts."""
    shift = max(hypot(*support.shift_W) for support in supports)
    if shift:
        return 1000.0 * shift, "mm"
    return max(abs(support.turn) for support in supports) * 180.0 / pi, "deg"


def settled_in(
    case: Case, name: str, until: float = inf, on_step: Callable[[float], None] = lambda _: None
) -> FollowedMotion:
    """Move the supports of a case called `name`, up to a multiple of their movement. Raises SearchError."""
    supports = case.timeline.world.supports
    if not supports:
        remedy = "write, for example, `supports: [{under: L1.1, by: [-20 mm, 0 mm, 0 mm]}]`"
        raise SearchError(f"the scenario has no `supports` that move; {remedy}")
    proofs = proofs_of(case.timeline)
    if proofs.assembly.strengths:
        raise SearchError(RIGID)
    if proofs.assembly.ties:
        raise SearchError(TIED)
    _require_standing(proofs.verdict.stability, proofs.verdict.reason)
    problem = proofs.assembly.problem()
    motion = support_path(problem, supports, proofs.assembly.loads, until=until, on_step=on_step)
    scale, unit = largest_movement(supports)
    weight = _weight(case)
    return FollowedMotion(name, Pushed.SUPPORTS, unit, scale, weight, motion, _why(motion))


def pushed_over_in(case: Case, name: str, on_step: Callable[[float], None] = lambda _: None) -> FollowedMotion:
    """Push a case called `name` over by its loads. Raises SearchError."""
    proofs = proofs_of(case.timeline)
    if proofs.assembly.strengths:
        raise SearchError(RIGID)
    if proofs.assembly.ties:
        raise SearchError(TIED)
    loads = case.timeline.final_world.loads
    if not any(hypot(*load.force) for load in loads.loads):
        remedy = "write, for example, `loads: [{acceleration: 0.1 g, towards: 0 deg, all: true}]`"
        raise SearchError(f"the scenario has no `loads` that are forces; {remedy}")
    unloaded = proofs.assembly.with_loads(type(loads)())
    _require_standing(unloaded.verdict().stability, unloaded.verdict().reason)
    motion = pushover(unloaded.problem(), loads, on_step=on_step)
    return FollowedMotion(name, Pushed.LOADS, "mm", 1000.0, _weight(case), motion)


def _weight(case: Case) -> float:
    return case.timeline.world.gravity * sum(placement.brick.mass for placement in case.timeline.placements)


def _require_standing(stability: Stability, reason: str) -> None:
    if stability is not Stability.STABLE:
        raise SearchError(f"the structure is not proven to stand: {reason or stability}")


def _why(motion: LargeMotion) -> str:
    if motion.motion is None or motion.problem is None:
        return ""
    return described(motion.problem, motion.motion)
