"""What is uncertain but the hands: samples of which each is compiled by itself, with values of its own."""

from collections.abc import Iterator

from scipy.special import ndtri

from stackdsl.compiling.compiler import compile_timeline
from stackdsl.language.uncertain import distributions, named
from stackdsl.language.validation import validate
from stackdsl.language.variants import Variant, resampled
from stackdsl.reading.source import Plain
from stackdsl.sampling.draws import Draws
from stackdsl.timeline import Timeline


class SampleMistakeError(Exception):
    """A sample has values that no scenario may have, such as a friction below zero."""


def drawn_values(variant: Variant, draws: Draws) -> Iterator[dict[str, Plain]]:
    """The values of each sample, as an author would write them."""
    found = dict(named(distributions(variant.written.values.get("uncertain"), {}, {})))
    numbers = {name: draws.uniform(f"= {name}")[0] for name in found}  # no brick is called so
    for sample in range(draws.count):
        yield {name: each.at(float(numbers[name][sample]), ndtri) for name, each in found.items()}


def timelines(variant: Variant, draws: Draws) -> Iterator[Timeline]:
    """The timeline of each sample. Raises SampleMistakeError."""
    for number, values in enumerate(drawn_values(variant, draws), start=draws.first):
        sample, mistaken = resampled(variant, values)
        scenario, mistakes = validate(sample.source, sample)
        timeline = None
        if scenario is not None and not mistaken:
            timeline, mistakes = compile_timeline(scenario, sample.source)
        if timeline is None:
            told = [mistake.message for _, mistake in mistaken.items()] or [f"{m.span}: {m.message}" for m in mistakes]
            which = ", ".join(f"{name} = {value}" for name, value in values.items())
            why = told[0] if told else "it cannot be built"
            hint = "let what is uncertain stay within what may be written, as a uniform or lognormal one does"
            raise SampleMistakeError(f"sample {number} has {which}: {why}; {hint}")
        yield timeline
