"""What the proof that a structure stands would survive. Solved where somebody asks: each is a program of its own."""

from collections.abc import Collection
from dataclasses import replace

from stability.statics.assembly import Assembly
from stability.statics.facts import Placed, Problem, Stability
from stability.statics.margins.summary import acceleration, least_friction, placement, tilt, weakest, weakest_at
from stability.statics.margins.weakest import Weakest
from stability.statics.outcomes.outcome import outcome
from stability.statics.solvers.separating_motion import separating_motion
from stackdsl.proof_margins import Margins
from stackdsl.trace import Trace

ALL = ("acceleration", "tilt", "friction", "placement")
MOST_FOR_PROGRAMS = 60  # bricks; beyond, margins and remedies take many seconds and come only when asked for


def margins_of(trace: Trace, wanted: Collection[str]) -> Margins:
    """Some margins of what stands frozen at the end of a run."""
    standing = [Placed(t.brick, t.final) for t in trace.tracks.values() if t.frozen]
    if trace.world is None or not standing:
        return Margins()
    assembly = trace.world.assembly()
    assembly.add_all(standing)
    return margins_of_assembly(assembly, wanted)


def margins_of_assembly(assembly: Assembly, wanted: Collection[str] = ALL) -> Margins:
    """Some margins of an assembly; none of one that is not proven to stand."""
    if not assembly.bricks or assembly.verdict().stability is not Stability.STABLE:
        return Margins()
    problem = assembly.problem()
    found = _shaken(problem, assembly.gravity) if {"acceleration", "tilt"}.intersection(wanted) else Margins()
    if "friction" in wanted:
        roughest = max((contact.friction for contact in problem.contacts), default=0.0)
        found = replace(found, friction=least_friction(problem).coefficient, roughest=roughest)
    if "placement" in wanted:
        planes = [plane.id for plane in assembly.planes]
        placed = placement(problem, planes=planes)
        found = replace(found, placement=placed.value, joint=placed.limit)
    if "guaranteed" in wanted:
        can_happen = outcome(problem, assembly.forces())
        found = replace(found, guaranteed=can_happen.guaranteed, certainty=can_happen.reason)
    if "squeezed" in wanted:
        found = replace(found, squeezed=separating_motion(problem) is None)
    return found


def weakest_of(assembly: Assembly) -> Weakest | None:
    """Which mechanism opens first; None of what is not proven to stand, or is held on all sides."""
    if not assembly.bricks or assembly.verdict().stability is not Stability.STABLE:
        return None
    return weakest(assembly.problem(), assembly.gravity)


def _shaken(problem: Problem, gravity: float) -> Margins:
    worst = acceleration(problem, gravity=gravity)
    if worst is None:
        return Margins()
    first = weakest_at(problem, worst)
    bearing = worst.bearing if first is None else first.bearing
    return Margins(worst.value, bearing, tilt(worst.value), weakest=first)
