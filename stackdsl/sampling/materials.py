"""What is uncertain but the hands: samples of which each is compiled by itself, with values of its own."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from scipy.special import ndtri

from stackdsl.compiling.compiler import compile_timeline
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.inline import Pick
from stackdsl.language.uncertain import Distribution, middle
from stackdsl.language.validation import validate
from stackdsl.language.variants import Variant, diagnostics_of, resampled
from stackdsl.reading.source import Plain
from stackdsl.sampling.draws import Draws
from stackdsl.timeline import Jitter, Spread, Timeline

WITHIN = "draw it within its limits: {normal: 0.5 ± 0.2, least: 0.1}, or one that has them, such as a lognormal one"
ELSEWHERE = "draw it within limits in which it can be built, such as 5 mm ± 1 mm"


class SampleMistakeError(Exception):
    """A sample has values that no scenario may have, such as a friction below zero."""

    def __init__(self, mistake: Diagnostic) -> None:
        super().__init__(mistake)  # so that it can be sent from process to process
        self.mistake = mistake

    def __str__(self) -> str:
        return self.mistake.message


@dataclass(frozen=True, slots=True)
class Setting:
    """What is otherwise than written, in all samples alike."""

    fixed: Mapping[str, Plain] = field(default_factory=dict)  # variables, and `friction`, with the values they have
    errors: float = 1.0  # by which the errors of hands are multiplied


AS_WRITTEN = Setting()


@dataclass(slots=True)
class Picks:
    """The values of one sample, as an author would write them."""

    draws: Draws  # of one sample
    values: dict[str, Plain] = field(default_factory=dict)  # by variable, as far as they were asked for

    def __call__(self, name: str, each: Distribution) -> Plain:
        """The value of a variable, whatever others there are."""
        number = float(self.draws.uniform(f"= {name}")[0, 0])  # no brick is called so
        self.values[name] = each.at(number, ndtri)
        return self.values[name]


def picks(draws: Draws) -> Iterator[Picks]:
    """For each sample."""
    for number in range(draws.first, draws.first + draws.count):
        yield Picks(replace(draws, first=number, count=1))


def timelines(variant: Variant, draws: Draws, setting: Setting = AS_WRITTEN) -> Iterator[Timeline]:
    """The timeline of each sample. Raises SampleMistakeError."""
    for pick in picks(draws):
        made = timeline_at(variant, setting, pick)
        if isinstance(made, Diagnostic):
            raise SampleMistakeError(_of_sample(pick, made, setting) if pick.values else made)
        yield made


def timeline_at(variant: Variant, setting: Setting, pick: Pick = middle) -> Timeline | Diagnostic:
    """The timeline with some values otherwise than written, or why there is none."""
    sample, mistaken = resampled(variant, pick, setting.fixed)
    scenario, mistakes = validate(sample.source, sample)
    timeline = None
    if scenario is not None and not mistaken:
        timeline, mistakes = compile_timeline(scenario, sample.source)
    if timeline is not None:
        return _with_errors(timeline, setting.errors)
    told = [*diagnostics_of([(sample.source, mistaken)]), *mistakes]
    first = told[0] if told else Diagnostic("SD104", sample.source.span_of(()), "it cannot be built")
    if not setting.fixed:
        return first
    fixed = ", ".join(f"{name} = {value}" for name, value in setting.fixed.items())
    return replace(first, message=f"with {fixed}: {first.message}")


def _of_sample(pick: Picks, mistake: Diagnostic, setting: Setting) -> Diagnostic:
    which = ", ".join(f"{name} = {value}" for name, value in pick.values.items())
    hint = WITHIN if mistake.code == "SD104" else ELSEWHERE
    hint = mistake.hint if setting.fixed else hint  # which may be what is out of range
    return replace(mistake, message=f"sample {pick.draws.first} has {which}: {mistake.message}", hint=hint)


def _with_errors(timeline: Timeline, times: float) -> Timeline:
    if times == 1.0:
        return timeline
    return replace(timeline, jitter={name: _multiplied(each, times) for name, each in timeline.jitter.items()})


def _multiplied(jitter: Jitter, times: float) -> Jitter:
    position, yaw = (
        None if each is None else Spread(each.kind, each.width * times) for each in (jitter.position, jitter.yaw)
    )
    return Jitter(position, yaw)
