"""When each brick is placed: steps in order, `every`, `at`, and anchors such as `after: level 9 + 1 s`."""

from collections import Counter
from collections.abc import Sequence

from stability.model import BodyId
from stackdsl.compiling.written import WrittenBrick
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.anchors import Anchor
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Source


def scheduled(
    written: Sequence[WrittenBrick], levels: Sequence[int], names: Sequence[BodyId], scenario: Scenario, source: Source
) -> tuple[list[float], list[Diagnostic]]:
    """The time of every brick [s]: a step begins at its time, after its event, or after the step before it."""
    times: list[float] = []
    mistakes: list[Diagnostic] = []
    last = next_start = 0.0
    counts = Counter(brick.step for brick in written)
    for number, step in enumerate(scenario.build):
        start = next_start if step.at is None else step.at
        if step.after is not None:
            event = _event_time(step.after, times, levels, names)
            if isinstance(event, str):
                mistakes.append(Diagnostic("SD205", source.span_of(("build", number, "after")), event, _ANCHOR_HINT))
            else:
                start = event + step.after.offset
        every = step.every or 0.0
        times += [start + index * every for index in range(counts[number])]
        last = max(last, times[-1])
        next_start = last + every
    return times, mistakes


_ANCHOR_HINT = "only what earlier steps of the build place can be waited for"


def _event_time(anchor: Anchor, times: Sequence[float], levels: Sequence[int], names: Sequence[str]) -> float | str:
    """When an event of the build so far is over [s], or why it never happens."""
    if anchor.event == "start":
        return 0.0
    meant = [
        time
        for time, level, name in zip(times, levels, names, strict=False)  # of later steps, no times are known yet
        if anchor.event == "built" or anchor.name == _place(anchor, level, name)
    ]
    if meant:
        return max(meant)
    what = {"built": "anything", "level": f"level {anchor.name}", "brick": f"brick '{anchor.name}'"}[anchor.event]
    return f"this step waits for {what}, and no earlier step builds it"


def _place(anchor: Anchor, level: int, name: str) -> str:
    return name if anchor.event == "brick" else str(level)
