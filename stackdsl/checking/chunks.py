"""A chunk of the samples of one case: what a worker does."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import process_time

from stability.statics.facts import Placed
from stackdsl.checking.one_case import play_case
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.variants import Variant
from stackdsl.playing.clearance import BlockedPlacementError
from stackdsl.sampling.design import Design, design_of
from stackdsl.sampling.draws import Draws
from stackdsl.sampling.fates import Fate, fates_of
from stackdsl.sampling.materials import AS_WRITTEN, SampleMistakeError, Setting, timelines
from stackdsl.sampling.setting_down import Hands
from stackdsl.systems.known_systems import system_named
from stackdsl.systems.systems import Method
from stackdsl.timeline import Placement, Timeline
from stackdsl.trace import Trace

PLAYED = "played"  # the way of systems that prove nothing


@dataclass(frozen=True, slots=True)
class Chunk:
    """What became of some samples, in order of their numbers: see `Fate`; and how many each way decided."""

    fates: tuple[int, ...]
    ways: dict[str, int]
    cpu_time: float  # [s]


def varied_chunk(variant: Variant, system: str, draws: Draws, setting: Setting = AS_WRITTEN) -> Chunk | Diagnostic:
    """What a worker does where more than hands is uncertain: judge each sample by itself; or what one has mistaken."""
    started = process_time()
    try:
        each = [
            judged_chunk(timeline, system, replace(draws, first=number, count=1))
            for number, timeline in enumerate(timelines(variant, draws, setting), start=draws.first)
        ]
    except SampleMistakeError as error:
        return error.mistake
    ways = Counter[str]()
    for one in each:
        ways.update(one.ways)
    return Chunk(tuple(one.fates[0] for one in each), dict(ways), process_time() - started)


def judged_chunk(timeline: Timeline, system: str, draws: Draws) -> Chunk:
    """What a worker does: judge some samples, by statics alone where the system proves."""
    started = process_time()
    each = judged_each(design_of(timeline), timeline, system, draws)
    ways = Counter(way for _, way in each if way)
    return Chunk(tuple(fate for fate, _ in each), dict(ways), process_time() - started)


def judged_each(design: Design, timeline: Timeline, system: str, draws: Draws) -> list[tuple[int, str]]:
    """The fate of each of some samples, and the way that decided it; no way where there was nothing to judge."""
    if system_named(system).method is Method.PROVEN:
        found = fates_of(design, draws)
        return [(fate, str(way or "")) for fate, way in zip(found.fates.tolist(), found.ways, strict=True)]
    hands = Hands(design, draws).build()
    return [
        (_played(timeline, hands.placed(sample), system), PLAYED) if hands.fits[sample] else (int(Fate.UNFIT), "")
        for sample in range(draws.count)
    ]


def _played(timeline: Timeline, placed: Sequence[Placed], system: str) -> int:
    """The fate of one sample on an engine, which is followed until it falls."""
    poses = {each.brick.id: each.pose for each in placed}
    actions = tuple(
        replace(action, pose=poses[action.brick.id]) if isinstance(action, Placement) else action
        for action in timeline.actions
    )
    sample = replace(timeline, actions=actions, jitter={}, aftermath=False, margins=(), told_margins=())
    try:
        trace = play_case(sample, system, has_fallen)
    except BlockedPlacementError:  # something had moved, and not as far as counts as fallen
        return int(Fate.UNDECIDED)
    return trace.collapse.level if trace.collapse is not None else int(Fate.STANDS)


def has_fallen(trace: Trace) -> bool:
    """Whether all is known of a sample."""
    return trace.collapse is not None
