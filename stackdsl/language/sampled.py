"""Do samples and what is uncertain go together? And is all of a scenario something that is known of samples?"""

from collections.abc import Iterator

from stackdsl.diagnostics import Diagnostic
from stackdsl.language.claims.claim import Claim
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Path, Source


def sampled(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """The mistakes of a scenario with samples, or of one that has what only those with samples have."""
    if scenario.samples is None:
        yield from _without_samples(scenario, source)
    else:
        yield from _nothing_uncertain(scenario, source)
        yield from _beyond_statics(scenario, source)
        yield from _of_one_run(scenario, source)


def _without_samples(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for key in ("seed", "confidence", "uncertain"):
        if key in scenario.model_fields_set:
            yield _mistake(source, (key,), f"there are no samples that this `{key}` could be of")
    for number, step in enumerate(scenario.build):
        if step.jitter is not None:
            yield _mistake(source, ("build", number, "jitter"), "where nothing is sampled, hands set down exactly")
    for key, number, claim in _claims(scenario):
        if claim.stated.wanted_share is not None:
            place: Path = (key, number, claim.kind, "share")
            yield _mistake(source, place, "there are no samples that this could be a share of")


def _mistake(source: Source, path: Path, message: str) -> Diagnostic:
    return Diagnostic("SD102", source.key_span_of(path), message, "add samples: 1000 to the scenario")


def _nothing_uncertain(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    if scenario.uncertain is None and all(step.jitter is None for step in scenario.build):
        message = "nothing is uncertain, so all samples would be the same"
        hint = "say jitter: {position: 1 mm, yaw: 1 deg} in a step of the build"
        yield Diagnostic("SD102", source.key_span_of(("samples",)), message, hint)


def _beyond_statics(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """What statics, which judges samples after each brick, has no word on."""
    hint = "leave it out, or the samples"
    if scenario.impacts:
        message = "samples are built and judged, and nothing else is done to them"
        yield Diagnostic("SD104", source.key_span_of(("impacts",)), message, hint)
    if scenario.world.shake is not None:
        message = "samples are built and judged on ground that is at rest"
        yield Diagnostic("SD104", source.key_span_of(("world", "shake")), message, hint)
    for number, step in enumerate(scenario.build):
        if step.place is not None:
            message = "in samples bricks are set down as if from nowhere, with their errors"
            yield Diagnostic("SD104", source.key_span_of(("build", number, "place")), message, "say `jitter` alone")
        for index, brick in enumerate(step.bricks or ()):
            if brick.drop:
                message = "in samples bricks are set down, and none is let go in the air"
                yield Diagnostic("SD104", source.key_span_of(("build", number, "bricks", index, "drop")), message, hint)


def _of_one_run(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for key, number, claim in _claims(scenario):
        if claim.stated.wanted_share is None:
            message = f"`{claim.kind}` speaks of one run, and there are samples of many"
            hint = 'write such as stands: {share: ">= 95 %"}, or collapses: {at: level 9 ± 1, share: ">= 90 %"}'
            yield Diagnostic("SD102", source.key_span_of((key, number, claim.kind)), message, hint)


def _claims(scenario: Scenario) -> Iterator[tuple[str, int, Claim]]:
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            yield key, number, claim
