"""Distributions in YAML: `uncertain:` variables and values such as `0.5 ± 0.05`."""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import erfc, exp, floor, inf, log, sqrt
from typing import TYPE_CHECKING, Final, TypeAlias

from stackdsl.diagnostics import Diagnostic
from stackdsl.language.claims.claim import Claim
from stackdsl.language.expressions import constant, unit_text
from stackdsl.language.quantities import QUANTITY, MistakeError, quantity_text, shown
from stackdsl.language.repeats import Mistakes, add, check_name
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import KeyPath, Plain, Source

if TYPE_CHECKING:
    from stackdsl.language.quantities import Amount


# Variables of which only the spread is known: `uncertain: {mu: 0.5 ± 0.05}`, with another value in each sample.
#
# The design has the middle of each. What two quantities have in common is said by expressions over one variable.


DIGITS: Final = 12  # of a value that is drawn: fewer than processors agree on
EXAMPLE: Final = "write 0.5 ± 0.05, normal 12 g ± 0.5 g least 10 g, lognormal 0.5 dispersion 0.2, or table 1 mm; 3 mm"
LIMITS: Final[tuple[str, ...]] = ("least", "most")
ONE_LINE: Final = ("uniform", "normal", "lognormal", "table")  # what one in one line may begin with
KEYS: Final = (*ONE_LINE, "dispersion", *LIMITS)
ONE_LINE_EXAMPLE: Final = "write such as normal 12 g ± 0.5 g least 10 g, or lognormal 0.5 dispersion 0.2"
RAREST: Final = 1e-9  # of what lies within the limits; of less, digits are lost, and nobody means it
_FURTHER = re.compile(rf",?\s+({'|'.join(('dispersion', *LIMITS))})\b")  # a comma ends a value within braces of YAML
_AROUND = re.compile(r"(.+?)\s*(?:±|\+/?-)\s*(.+)")
_BETWEEN = re.compile(r"(.+?)\s*\.\.\s*(.+)")
Normal = Callable[[float], float]  # from a number between 0 and 1 to so many standard deviations


@dataclass(frozen=True, slots=True)
class Distribution:
    """How a variable is spread, in SI."""

    kind: str
    unit: str
    numbers: tuple[float, ...]  # both ends; or mean and standard deviation; or median and dispersion; or a table
    limits: tuple[float, float] = (-inf, inf)  # beyond which nothing is drawn

    @property
    def middle(self) -> Plain:
        """The value that the design has: half of all are below it."""
        if self.limits != (-inf, inf):
            from statistics import NormalDist  # noqa: PLC0415 -- few are cut off

            return self.at(0.5, NormalDist().inv_cdf)
        return self._written(Fraction(repr(self._value(0.5, lambda _: 0.0))))

    def at(self, uniform: float, normal: Normal) -> Plain:
        """The value below which this share of all lies, as an author would write it."""
        value = min(max(self._value(uniform, normal), self.limits[0]), self.limits[1])
        return self._written(Fraction(f"{value:.{DIGITS}g}"))

    def _written(self, value: Fraction) -> Plain:
        if self.unit:
            return quantity_text(value, self.unit)
        return int(value) if self.kind == "table" and value.denominator == 1 else float(value)

    def _value(self, uniform: float, normal: Normal) -> float:
        first, second = self.numbers[0], self.numbers[-1]
        match self.kind:
            case "uniform":
                return first + (second - first) * uniform
            case "normal":
                return first + second * self._within(uniform, normal)
            case "lognormal":
                return first * exp(second * self._within(uniform, normal))
            case _:
                return self.numbers[floor(uniform * len(self.numbers))]

    def _within(self, uniform: float, normal: Normal) -> float:
        """So many standard deviations, none beyond the limits: what lies beyond is left out, not moved to them."""
        if self.limits == (-inf, inf):
            return normal(uniform)
        low, high = (self._deviations(limit) for limit in self.limits)
        if low > 0.0:  # above the middle shares are near to one, where digits are lost: seen from the other side
            return -_between(-high, -low, 1.0 - uniform, normal)
        return _between(low, high, uniform, normal)

    @property
    def share_within(self) -> float:
        """The share of all that lies within the limits."""
        low, high = (self._deviations(limit) for limit in self.limits)
        low, high = (-high, -low) if low > 0.0 else (low, high)
        return _share_below(high) - _share_below(low)

    def _deviations(self, limit: float) -> float:
        """How many standard deviations a limit is above the middle."""
        if self.kind == "lognormal":
            return -inf if limit <= 0.0 else (log(limit / self.numbers[0]) / self.numbers[1])
        return (limit - self.numbers[0]) / self.numbers[1]


def _between(low: float, high: float, uniform: float, normal: Normal) -> float:
    """So many standard deviations, between two numbers of them."""
    least, most = _share_below(low), _share_below(high)
    return normal(least + (most - least) * uniform)


def _share_below(deviations: float) -> float:
    return 0.5 * erfc(-deviations / sqrt(2.0))


def distributions(written: Plain, taken: Mapping[str, object], mistakes: Mistakes) -> dict[str, Distribution | None]:
    """The variables of `uncertain`; None where one is mistaken. `taken` are the names that are in use."""
    if not isinstance(written, dict) or not written:
        add(mistakes, ("uncertain",), MistakeError("SD103", "expected a mapping of variables", EXAMPLE))
        return {}
    found: dict[str, Distribution | None] = {}
    for name, spread in written.items():
        try:
            check_name(name, taken, "the matrix")
            found[name] = distribution(spread)
        except MistakeError as mistake:
            add(mistakes, ("uncertain", name), mistake)
            found[name] = None
    return found


def distribution(written: Plain) -> Distribution:
    """How one variable is spread. Raises MistakeError."""
    if isinstance(written, str) and (worded := _in_one_line(written)) is not None:
        written = worded
    if not isinstance(written, dict):
        return _uniform(written)
    limits: dict[str, Plain] = {key: written[key] for key in LIMITS if key in written}
    found = _of_keys({key: value for key, value in written.items() if key not in LIMITS}, written)
    return _limited(found, limits) if limits else found


def _of_keys(written: Mapping[str, Plain], whole: Plain) -> Distribution:
    keys = set(written)
    if keys == {"uniform"}:
        return _uniform(written["uniform"])
    if keys == {"normal"}:
        middle, width = _pair(written["normal"], _AROUND)
        return _made("normal", middle, width, positive=True)
    if keys == {"lognormal", "dispersion"}:
        median, dispersion = _amount(written["lognormal"]), _amount(written["dispersion"])
        if unit_text(dispersion):
            raise MistakeError("SD104", "a dispersion is a number", "write such as 0.2, of the logarithm")
        if median.magnitude <= 0 or dispersion.magnitude <= 0:
            raise MistakeError("SD104", "median and dispersion are more than zero", EXAMPLE)
        numbers = (float(median.magnitude), float(dispersion.magnitude))
        return Distribution("lognormal", unit_text(median), numbers)
    if keys == {"table"}:
        return _table(written["table"])
    raise MistakeError("SD103", f"{shown(whole)} is no distribution", EXAMPLE)


def _in_one_line(text: str) -> Plain:
    """The mapping that `normal 0.5 ± 0.2 least 0.1` is short for; None of what begins with no such word."""
    word, _, rest = text.strip().partition(" ")
    if word not in ONE_LINE:
        return None
    if word == "table":
        return {"table": [part.strip() for part in re.split("[;,]", rest)]}
    first, *others = _FURTHER.split(rest)
    found: dict[str, Plain] = {word: first.strip()}
    for key, value in zip(others[::2], others[1::2], strict=True):
        if not value.strip() or key in found:
            raise MistakeError("SD103", f"{shown(text)} cannot be read at '{key}'", ONE_LINE_EXAMPLE)
        found[key] = value.strip()
    return found


def _limited(found: Distribution, written: Mapping[str, Plain]) -> Distribution:
    """The same, with nothing beyond its limits."""
    if found.kind not in ("normal", "lognormal"):
        message = f"a {found.kind} distribution has its limits"
        raise MistakeError("SD104", message, "leave `least` and `most` to normal and lognormal ones")
    limits = {}
    for key, value in written.items():
        amount = _amount(value)
        if unit_text(amount) != found.unit and amount.magnitude != 0:
            raise MistakeError("SD104", f"`{key}` is of another kind than what it limits", "give it the same unit")
        limits[key] = float(amount.magnitude)
    low, high = limits.get("least", -inf), limits.get("most", inf)
    made = replace(found, limits=(low, high))
    if low >= high or made.share_within < RAREST:
        raise MistakeError("SD104", "hardly anything lies within `least` and `most`", "let them hold more of it")
    return made


def _uniform(written: Plain) -> Distribution:
    text = written if isinstance(written, str) else ""
    if _BETWEEN.fullmatch(text.strip()):
        low, high = _pair(written, _BETWEEN)
        if low.magnitude >= high.magnitude:
            raise MistakeError("SD104", f"{shown(written)} leaves no room", "write the smaller end first")
        return _made("uniform", low, high)
    middle, width = _pair(written, _AROUND)
    if width.magnitude <= 0:
        raise MistakeError("SD104", f"{shown(written)} leaves no room", "write a width that is more than zero")
    return _made("uniform", middle - width, middle + width)


def _table(written: Plain) -> Distribution:
    if not isinstance(written, list) or not written:
        raise MistakeError("SD103", f"expected a list of values, not {shown(written)}", EXAMPLE)
    amounts = [_amount(each) for each in written]
    units = {unit_text(amount) for amount in amounts}
    if len(units) > 1:
        raise MistakeError("SD104", "the values of a table are of several kinds", "give all a unit of one kind")
    return Distribution("table", units.pop(), tuple(sorted(float(amount.magnitude) for amount in amounts)))


def _made(kind: str, first: "Amount", second: "Amount", *, positive: bool = False) -> Distribution:
    if positive and second.magnitude <= 0:
        raise MistakeError("SD104", "a standard deviation is more than zero", EXAMPLE)
    return Distribution(kind, unit_text(first), (float(first.magnitude), float(second.magnitude)))


def _pair(written: Plain, form: "re.Pattern[str]") -> tuple["Amount", "Amount"]:
    """Both parts of a text; a unit that stands only at the end is for both."""
    match = form.fullmatch(written.strip()) if isinstance(written, str) else None
    if match is None:
        raise MistakeError("SD103", f"{shown(written)} is no distribution", EXAMPLE)
    first, second = _amount(match[1]), _amount(match[2])
    if unit_text(second) and not unit_text(first):
        first = _amount(f"{match[1]} {match[2].lstrip('+-.0123456789eE')}")
    if unit_text(first) != unit_text(second):
        raise MistakeError("SD104", f"{shown(written)} has parts of several kinds", "give both a unit of one kind")
    return first, second


def _amount(written: Plain) -> "Amount":
    return constant(written, EXAMPLE)


def named(found: Mapping[str, Distribution | None]) -> Iterator[tuple[str, Distribution]]:
    """Those without a mistake."""
    yield from ((name, each) for name, each in found.items() if each is not None)


def middle(_: str, each: Distribution) -> Plain:
    """What the design has of a variable."""
    return each.middle


# Distributions in place of a value: `friction: 0.5 ± 0.05`, each a variable of its own that has no name.
#
# Done for each variant once its expressions are worked out and its repeats written out, so that every repetition has a
# variable of its own, and all later stages see a plain value.


ROOTS: Final = ("friction", "world", "brick", "brick_types", "build")  # what is built, and of what
# What a step says of when and by whose hands, and what it is called.
NOT_OF_A_STEP: Final = ("repeat", "name", "every", "until", "place", "jitter", "at", "after", "import")
SILENT: Final = "${}"  # in place of what is mistaken and told: whoever validates it passes over it
_MARK: Final = re.compile(r"±|\+/?-|\.\.|^(?:" + "|".join(ONE_LINE) + ") ")
_EITHER: Final = re.compile(r"(.+?)\s*(?:±|\+/?-|\.\.)\s*(.+)")

Pick: TypeAlias = Callable[[str, Distribution], Plain]  # the value that a variable has


def is_inline(written: Plain) -> bool:
    """Whether a value is a distribution in one line."""
    if not isinstance(written, str):
        return False
    text = written.strip()
    if not _MARK.search(text):
        return False
    if text.partition(" ")[0] in ONE_LINE and " " in text:
        return True
    match = _EITHER.fullmatch(text)
    return match is not None and all(QUANTITY.fullmatch(part) for part in match.groups())


def subject(path: KeyPath) -> str:
    """What the variable at a path is called: `build[0].column.step`."""
    text = "".join(f"[{each}]" if isinstance(each, int) else f".{each}" for each in path)
    return text.removeprefix(".")


class Inline:
    """Puts values in place of the distributions of a variant."""

    def __init__(self, pick: Pick, mistakes: Mistakes) -> None:
        self.found: dict[KeyPath, Plain] = {}  # by path, as written
        self._pick, self._mistakes = pick, mistakes

    def of(self, value: Plain, path: KeyPath) -> Plain:
        """A value without distributions."""
        if path[0] not in ROOTS or (path[0] == "build" and path[2:] in _LEFT_TO_STEPS):
            return value
        if isinstance(value, dict) and _is_spelt_out(value, path):
            add(
                self._mistakes,
                path,
                MistakeError("SD103", "in place of a value a distribution is one line", _line(value)),
            )
            return SILENT
        if isinstance(value, dict):
            return {key: self.of(member, (*path, key)) for key, member in value.items()}
        if isinstance(value, list):
            return [self.of(item, (*path, index)) for index, item in enumerate(value)]
        return self._picked(value, path) if is_inline(value) and path[-1] != "name" else value

    def _picked(self, written: Plain, path: KeyPath) -> Plain:
        try:
            value = self._pick(subject(path), distribution(written))
        except MistakeError as mistake:
            add(self._mistakes, path, mistake)
            return SILENT
        self.found[path] = written
        return value

    def without_samples(self) -> Iterator[tuple[KeyPath, MistakeError]]:
        """The mistakes where there are no samples of which each could have another value."""
        for path, written in self.found.items():
            message = f"'{written}' is another value in each sample, and there are no samples"
            yield path, MistakeError("SD102", message, "add samples: 1000 to the scenario, or write one value")


def _is_spelt_out(value: Mapping[str, Plain], path: KeyPath) -> bool:
    """Whether a mapping is a distribution, as `uncertain` has it."""
    elsewhere = path[:2] == ("world", "shake") or "jitter" in path or path == ("brick_types",)  # have keys called so
    return not elsewhere and any(kind in value for kind in ONE_LINE) and value.keys() <= {*KEYS}


def _line(value: Mapping[str, Plain]) -> str:
    """The same in one line."""
    kind = next(key for key in ONE_LINE if key in value)
    first = value[kind]
    table = "; ".join(map(str, first)) if isinstance(first, list) else str(first)
    return " ".join(["write", kind, table, *(f"{key} {value[key]}" for key in KEYS if key in value and key != kind)])


_LEFT_TO_STEPS: Final = tuple((key,) for key in NOT_OF_A_STEP)


# Do samples and what is uncertain go together? And is all of a scenario something that is known of samples?


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
            place: KeyPath = (key, number, claim.kind, "share")
            yield _mistake(source, place, "there are no samples that this could be a share of")


def _mistake(source: Source, path: KeyPath, message: str) -> Diagnostic:
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
