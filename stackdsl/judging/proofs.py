"""Timeline -> proofs: what statics says of each placement, without any engine.

What falls, and where something dropped comes to lie, only an engine can tell. From there on nothing is judged.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from stability.model import BodyId
from stability.motion.onset import as_it_begins
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed, Stability, Stage, Tolerances, Verdict
from stability.statics.outcomes.first_start import lets_go
from stackdsl.timeline import Handled, Push, Removal, Shake, Timeline, leaves_to_engine
from stackdsl.trace import Trace

DISPROVED = "statics prove that it stands"


@dataclass(frozen=True, slots=True)
class Judged:
    """Bricks set down together."""

    bricks: tuple[BodyId, ...]
    verdict: Verdict  # of all that stands, with them
    stages: Mapping[BodyId, Stage | None]  # what proved each of them then; later bricks may bring in another proof


@dataclass(frozen=True, slots=True)
class Proofs:
    """What was judged, in order of time."""

    judged: tuple[Judged, ...]
    assembly: Assembly  # all that was judged
    verdict: Verdict  # of all that was judged; of a fall, with what begins to move and how, if that was wanted
    done: int = 0  # of the actions of the timeline, those that were judged


def proofs_of(timeline: Timeline, names_smallest: bool = True) -> Proofs:
    """Judge every action as `exact` does, up to the first one that leaves anything to the engine.

    With `names_smallest` a fall is proven by as few bricks as are found to fall, which of a heap takes seconds, and the
    verdicts are told `as_it_begins`: that is what everybody is told of it, and what an engine is given.
    """
    assembly = timeline.world.assembly()
    judged: list[Judged] = []
    done = 0
    for moment in timeline.as_set_down().moments():
        if isinstance(moment, Removal):
            done += 1
            if assembly.remove(moment.bricks, names_smallest=names_smallest).stability is not Stability.STABLE:
                break
            continue
        if isinstance(moment, Push | Shake | Handled):
            break
        set_down = [placement for placement in moment if placement.at_rest]
        if set_down:
            coming = [Placed(placement.brick, placement.pose) for placement in set_down]
            verdict = assembly.add_all(coming, names_smallest=names_smallest)
            if names_smallest:
                verdict = as_it_begins(assembly, verdict)
            done += len(moment)
            names = tuple(placement.brick.id for placement in set_down)
            judged.append(Judged(names, verdict, {name: assembly.stage(name) for name in names}))
        if len(set_down) < len(moment) or assembly.verdict().stability is not Stability.STABLE:
            break
    last = as_it_begins(assembly, assembly.verdict()) if names_smallest else assembly.verdict()
    return Proofs(tuple(judged), assembly, last, done)


def held_against_statics(trace: Trace, timeline: Timeline) -> Trace:
    """The trace; a collapse before which every structure was proven to stand is marked as numerical.

    One that had to come has the proof of it. Neither is said of one that could come as well as not.
    """
    proofs = proofs_until(timeline, trace.collapse.time) if trace.collapse is not None else None
    if proofs is None:
        return trace
    verdict = proofs.verdict
    if verdict.stability is Stability.UNSTABLE:
        return replace(trace, disproof=verdict)
    if verdict.stability is Stability.UNDECIDED or lets_go(proofs.assembly.problem(), Tolerances()) is not None:
        return trace
    return replace(trace, numerical=DISPROVED)


def stands_until(timeline: Timeline, time: float) -> bool:
    """Whether all that was built is proven to stand, after everything that was done up to a time [s]."""
    return verdict_until(timeline, time).stability is Stability.STABLE


def verdict_until(timeline: Timeline, time: float) -> Verdict:
    """The first verdict that is not STABLE, of all that was built up to a time [s], or STABLE.

    UNDECIDED from the first thing on that only an engine can follow: what is dropped, thrown or pushed.
    """
    proofs = proofs_until(timeline, time)
    if proofs is None:
        return Verdict(
            Stability.UNDECIDED, reason="something is dropped, thrown or pushed, which only an engine can follow"
        )
    return proofs.verdict


def proofs_until(timeline: Timeline, time: float) -> Proofs | None:
    """What is proven of all that was built up to a time [s]; None where only an engine can follow what was done."""
    timeline = timeline.as_set_down()
    done = tuple(action for action in timeline.actions if action.time <= time)
    if not done or any(leaves_to_engine(action) for action in done):
        return None
    return proofs_of(replace(timeline, actions=done))
