"""When each brick is placed: steps in order, `every`, `at`, and anchors such as `after: level 9 + 1 s`."""

from collections.abc import Sequence
from dataclasses import replace

from stability.model import BodyId
from stackdsl.compiling.written import WrittenBrick
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.anchors import Anchor
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Source


def scheduled(
    written: Sequence[WrittenBrick], levels: Sequence[int], names: Sequence[BodyId], scenario: Scenario, source: Source
) -> tuple[list[WrittenBrick], list[Diagnostic]]:
    """Every brick with its time: a step begins at its time, after its event, or after the step before it."""
    timed: list[WrittenBrick] = []
    mistakes: list[Diagnostic] = []
    next_start = 0.0
    for number, step in enumerate(scenario.build):
        start = next_start if step.at is None else step.at
        if step.after is not None:
            event = _event_time(step.after, timed, levels, names)
            if isinstance(event, str):
                mistakes.append(Diagnostic("SD205", source.span_of(("build", number, "after")), event, _ANCHOR_HINT))
            else:
                start = event + step.after.offset
        own = [brick for brick in written if brick.step == number]
        every = step.every or 0.0
        timed += [replace(brick, time=start + index * every) for index, brick in enumerate(own)]
        next_start = max(brick.time for brick in timed) + every
    return timed, mistakes


_ANCHOR_HINT = "only what earlier steps of the build place can be waited for"


def _event_time(
    anchor: Anchor, timed: Sequence[WrittenBrick], levels: Sequence[int], names: Sequence[str]
) -> float | str:
    """When an event of the build so far is over [s], or why it never happens."""
    if anchor.event == "start":
        return 0.0
    meant = [
        i for i in range(len(timed)) if anchor.event == "built" or anchor.name == _place(anchor, levels[i], names[i])
    ]
    if meant:
        return max(timed[index].time for index in meant)
    what = {"built": "anything", "level": f"level {anchor.name}", "brick": f"brick '{anchor.name}'"}[anchor.event]
    return f"this step waits for {what}, and no earlier step builds it"


def _place(anchor: Anchor, level: int, name: str) -> str:
    return name if anchor.event == "brick" else str(level)
