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
from stackdsl.language.quantities import QUANTITY, InputError, quantity_text, shown
from stackdsl.language.repeats import Mistakes, add, check_name
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import KeyPath, Plain, Source

if TYPE_CHECKING:
    from stackdsl.language.quantities import Amount


# Random variables: `uncertain: {mu: 0.5 ± 0.05}`, with another value in each sample.
#
# The nominal structure has the median of each. Quantities with a common cause are expressions of one variable.


DIGITS: Final = 12  # of a drawn value: few enough to be the same on all processors
EXAMPLE: Final = "write 0.5 ± 0.05, normal 12 g ± 0.5 g least 10 g, lognormal 0.5 dispersion 0.2, or table 1 mm; 3 mm"
LIMITS: Final[tuple[str, ...]] = ("least", "most")
ONE_LINE: Final = ("uniform", "normal", "lognormal", "table")  # first words of a distribution on one line
KEYS: Final = (*ONE_LINE, "dispersion", *LIMITS)
ONE_LINE_EXAMPLE: Final = "write, for example, normal 12 g ± 0.5 g least 10 g, or lognormal 0.5 dispersion 0.2"
RAREST: Final = 1e-9  # least probability within the limits; a smaller one loses digits, and is a mistake
_FURTHER = re.compile(rf",?\s+({'|'.join(('dispersion', *LIMITS))})\b")  # a comma is possible outside of YAML braces
_AROUND = re.compile(r"(.+?)\s*(?:±|\+/?-)\s*(.+)")
_BETWEEN = re.compile(r"(.+?)\s*\.\.\s*(.+)")
Normal = Callable[[float], float]  # inverse of the standard normal distribution function


@dataclass(frozen=True, slots=True)
class Distribution:
    """The distribution of a variable, in SI."""

    kind: str
    unit: str
    numbers: tuple[float, ...]  # both ends; or mean and standard deviation; or median and dispersion; or a table
    limits: tuple[float, float] = (-inf, inf)  # of a truncated distribution

    @property
    def middle(self) -> Plain:
        """Return the median, the value of the nominal structure."""
        if self.limits != (-inf, inf):
            from statistics import NormalDist  # noqa: PLC0415 -- only truncated distributions need it

            return self.at(0.5, NormalDist().inv_cdf)
        return self._written(Fraction(repr(self._value(0.5, lambda _: 0.0))))

    def at(self, uniform: float, normal: Normal) -> Plain:
        """Return the quantile of a probability `uniform`, as written in YAML."""
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
        """Return the quantile of the truncated standard normal distribution, in standard deviations.

        Values beyond the limits are not moved to the limits; the distribution within them is scaled up.
        """
        if self.limits == (-inf, inf):
            return normal(uniform)
        low, high = (self._deviations(limit) for limit in self.limits)
        if low > 0.0:  # probabilities near one lose digits, so mirror the interval
            return -_between(-high, -low, 1.0 - uniform, normal)
        return _between(low, high, uniform, normal)

    @property
    def share_within(self) -> float:
        """Return the probability within the limits."""
        low, high = (self._deviations(limit) for limit in self.limits)
        low, high = (-high, -low) if low > 0.0 else (low, high)
        return _share_below(high) - _share_below(low)

    def _deviations(self, limit: float) -> float:
        """Return the distance of a limit from the median, in standard deviations."""
        if self.kind == "lognormal":
            return -inf if limit <= 0.0 else (log(limit / self.numbers[0]) / self.numbers[1])
        return (limit - self.numbers[0]) / self.numbers[1]


def _between(low: float, high: float, uniform: float, normal: Normal) -> float:
    """Return a quantile of the standard normal distribution truncated to an interval, in standard deviations."""
    least, most = _share_below(low), _share_below(high)
    return normal(least + (most - least) * uniform)


def _share_below(deviations: float) -> float:
    return 0.5 * erfc(-deviations / sqrt(2.0))


def distributions(
    written: Plain, used_names: Mapping[str, object], mistakes: Mistakes
) -> dict[str, Distribution | None]:
    """Read the variables of `uncertain`, as None where one has a mistake. used_names are names already in use."""
    if not isinstance(written, dict) or not written:
        add(
            mistakes,
            ("uncertain",),
            InputError("SD103", "expected a mapping of variables to distributions", EXAMPLE),
        )
        return {}
    by_name: dict[str, Distribution | None] = {}
    for name, spread in written.items():
        try:
            check_name(name, used_names, "the matrix")
            by_name[name] = distribution(spread)
        except InputError as mistake:
            add(mistakes, ("uncertain", name), mistake)
            by_name[name] = None
    return by_name


def distribution(written: Plain) -> Distribution:
    """Read the distribution of one variable. Raises InputError."""
    if isinstance(written, str) and (mapping := _in_one_line(written)) is not None:
        written = mapping
    if not isinstance(written, dict):
        return _uniform(written)
    limits: dict[str, Plain] = {key: written[key] for key in LIMITS if key in written}
    unlimited = _of_keys({key: value for key, value in written.items() if key not in LIMITS}, written)
    return _limited(unlimited, limits) if limits else unlimited


def _of_keys(written: Mapping[str, Plain], whole: Plain) -> Distribution:
    keys = set(written)
    if keys == {"uniform"}:
        return _uniform(written["uniform"])
    if keys == {"normal"}:
        if QUANTITY.fullmatch(str(written["normal"]).strip()):
            hint = f"write, for example, normal {written['normal']} ± 5 %"
            raise InputError("SD103", "a normal distribution needs a standard deviation", hint)
        middle, width = _pair(written["normal"], _AROUND)
        return _made("normal", middle, width, positive=True)
    if keys == {"lognormal", "dispersion"}:
        median, dispersion = _amount(written["lognormal"]), _amount(written["dispersion"])
        if unit_text(dispersion):
            hint = "write the standard deviation of the logarithm, for example 0.2"
            raise InputError("SD104", "a dispersion has no unit", hint)
        if median.magnitude <= 0 or dispersion.magnitude <= 0:
            raise InputError("SD104", "median and dispersion must be greater than zero", EXAMPLE)
        numbers = (float(median.magnitude), float(dispersion.magnitude))
        return Distribution("lognormal", unit_text(median), numbers)
    if keys == {"lognormal"}:
        hint = f"write, for example, lognormal {written['lognormal']} dispersion 0.2"
        raise InputError("SD103", "a lognormal distribution needs a dispersion", hint)
    if keys == {"table"}:
        return _table(written["table"])
    raise InputError("SD103", f"{shown(whole)} is not a distribution", EXAMPLE)


def _in_one_line(text: str) -> Plain:
    """Return the mapping for text such as `normal 0.5 ± 0.2 least 0.1`; None if it begins with another word."""
    word, _, rest = text.strip().partition(" ")
    if word not in ONE_LINE:
        return None
    if word == "table":
        return {"table": [part.strip() for part in re.split("[;,]", rest)]}
    first, *others = _FURTHER.split(rest)
    mapping: dict[str, Plain] = {word: first.strip()}
    for key, value in zip(others[::2], others[1::2], strict=True):
        if not value.strip() or key in mapping:
            raise InputError("SD103", f"{shown(text)} cannot be read at '{key}'", ONE_LINE_EXAMPLE)
        mapping[key] = value.strip()
    return mapping


def _limited(unlimited: Distribution, written: Mapping[str, Plain]) -> Distribution:
    """Return the distribution truncated to limits. Raises InputError."""
    if unlimited.kind not in ("normal", "lognormal"):
        message = f"`least` and `most` do not apply to a {unlimited.kind} distribution"
        raise InputError("SD104", message, "remove them, or use a normal or lognormal distribution")
    limits = {}
    for key, value in written.items():
        amount = _amount(value)
        if unit_text(amount) != unlimited.unit and amount.magnitude != 0:
            raise InputError(
                "SD104", f"the unit of `{key}` differs from the unit of its distribution", "use the same unit for both"
            )
        limits[key] = float(amount.magnitude)
    low, high = limits.get("least", -inf), limits.get("most", inf)
    limited = replace(unlimited, limits=(low, high))
    if low >= high or limited.share_within < RAREST:
        raise InputError(
            "SD104", "the probability of values between `least` and `most` is almost zero", "widen the limits"
        )
    return limited


def _uniform(written: Plain) -> Distribution:
    text = written if isinstance(written, str) else ""
    if _BETWEEN.fullmatch(text.strip()):
        low, high = _pair(written, _BETWEEN)
        if low.magnitude >= high.magnitude:
            raise InputError("SD104", f"the range {shown(written)} is empty", "write the smaller limit first")
        return _made("uniform", low, high)
    middle, width = _pair(written, _AROUND)
    if width.magnitude <= 0:
        raise InputError("SD104", f"the range {shown(written)} is empty", "write a width greater than zero")
    return _made("uniform", middle - width, middle + width)


def _table(written: Plain) -> Distribution:
    if not isinstance(written, list) or not written:
        raise InputError("SD103", f"expected a list of values, not {shown(written)}", EXAMPLE)
    amounts = [_amount(value) for value in written]
    units = {unit_text(amount) for amount in amounts}
    if len(units) > 1:
        raise InputError(
            "SD104", "the values of the table have different units", "use the same kind of unit for all values"
        )
    return Distribution("table", units.pop(), tuple(sorted(float(amount.magnitude) for amount in amounts)))


def _made(kind: str, first: "Amount", second: "Amount", *, positive: bool = False) -> Distribution:
    if positive and second.magnitude <= 0:
        raise InputError("SD104", "a standard deviation must be greater than zero", EXAMPLE)
    return Distribution(kind, unit_text(first), (float(first.magnitude), float(second.magnitude)))


def _pair(written: Plain, form: "re.Pattern[str]") -> tuple["Amount", "Amount"]:
    """Return both parts of a text. A unit that is only at the end applies to both."""
    match = form.fullmatch(written.strip()) if isinstance(written, str) else None
    if match is None:
        raise InputError("SD103", f"{shown(written)} is not a distribution", EXAMPLE)
    first, second = _amount(match[1]), _amount(match[2])
    if unit_text(second) and not unit_text(first):
        first = _amount(f"{match[1]} {match[2].lstrip('+-.0123456789eE')}")
    if unit_text(first) != unit_text(second):
        raise InputError("SD104", f"the parts of {shown(written)} have different units", "use the same unit for both")
    return first, second


def _amount(written: Plain) -> "Amount":
    return constant(written, EXAMPLE)


def named(by_name: Mapping[str, Distribution | None]) -> Iterator[tuple[str, Distribution]]:
    """Yield the variables without mistakes."""
    yield from ((name, each) for name, each in by_name.items() if each is not None)


def middle(_: str, each: Distribution) -> Plain:
    """Return the value of a variable in the nominal structure."""
    return each.middle


# Distributions in place of a value: `friction: 0.5 ± 0.05`, each a variable without a name.
#
# Replaced in each variant after its expressions and repeats are expanded, so that every repetition has its own
# variable, and all later stages see a plain value.


ROOTS: Final = ("friction", "world", "brick", "brick_types", "build")  # keys that may hold distributions
# Keys of a build step that may not: its name and its timing, and the actions of hands.
NOT_OF_A_STEP: Final = ("repeat", "name", "every", "until", "place", "jitter", "at", "after", "import")
SILENT: Final = "${}"  # replaces a value with a reported mistake: validation skips it
_MARK: Final = re.compile(r"±|\+/?-|\.\.|^(?:" + "|".join(ONE_LINE) + ") ")
_EITHER: Final = re.compile(r"(.+?)\s*(?:±|\+/?-|\.\.)\s*(.+)")

Pick: TypeAlias = Callable[[str, Distribution], Plain]  # chooses the value of a variable by its name and distribution


def is_inline(written: Plain) -> bool:
    """Return whether a value is a distribution on one line."""
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
    """Return the name of the variable at a path: `build[0].column.step`."""
    text = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path)
    return text.removeprefix(".")


class Inline:
    """Replaces the distributions of a variant by values."""

    def __init__(self, pick: Pick, mistakes: Mistakes) -> None:
        self.found: dict[KeyPath, Plain] = {}  # distributions by path, as written
        self._pick, self._mistakes = pick, mistakes

    def of(self, value: Plain, path: KeyPath) -> Plain:
        """Return the value at a path with its distributions replaced."""
        if path[0] not in ROOTS or (path[0] == "build" and path[2:] in _LEFT_TO_STEPS):
            return value
        if isinstance(value, dict) and _is_spelt_out(value, path):
            add(
                self._mistakes,
                path,
                InputError("SD103", "a distribution that replaces a value must be written on one line", _line(value)),
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
        except InputError as mistake:
            add(self._mistakes, path, mistake)
            return SILENT
        self.found[path] = written
        return value

    def without_samples(self) -> Iterator[tuple[KeyPath, InputError]]:
        """Yield a mistake for each distribution, for scenarios without samples."""
        for path, written in self.found.items():
            message = f"'{written}' is a distribution, but the scenario has no samples"
            yield (
                path,
                InputError("SD102", message, "add `samples: 1000` to the scenario, or write a single value"),
            )


def _is_spelt_out(value: Mapping[str, Plain], path: KeyPath) -> bool:
    """Return whether a mapping is a distribution as under `uncertain`."""
    elsewhere = path[:2] == ("world", "shake") or "jitter" in path or path == ("brick_types",)  # have the same keys
    return not elsewhere and any(kind in value for kind in ONE_LINE) and value.keys() <= {*KEYS}


def _line(value: Mapping[str, Plain]) -> str:
    """Return the remedy: the same distribution on one line."""
    kind = next(key for key in ONE_LINE if key in value)
    first = value[kind]
    table = "; ".join(map(str, first)) if isinstance(first, list) else str(first)
    return " ".join(["write", kind, table, *(f"{key} {value[key]}" for key in KEYS if key in value and key != kind)])


_LEFT_TO_STEPS: Final = tuple((key,) for key in NOT_OF_A_STEP)


# Consistency of samples, uncertain values, and the rest of a scenario.


def sampled(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Yield keys that do not go with samples, or that need samples where there are none."""
    if scenario.samples is None:
        yield from _without_samples(scenario, source)
    else:
        yield from _nothing_uncertain(scenario, source)
        yield from _beyond_statics(scenario, source)
        yield from _of_one_run(scenario, source)


def _without_samples(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for key in ("seed", "confidence", "uncertain"):
        if key in scenario.model_fields_set:
            yield _mistake(source, (key,), f"`{key}` has no effect without samples")
    for number, step in enumerate(scenario.build):
        if step.jitter is not None:
            yield _mistake(source, ("build", number, "jitter"), "`jitter` has no effect without samples")
    for key, number, claim in _claims(scenario):
        if claim.content.wanted_share is not None:
            place: KeyPath = (key, number, claim.kind, "share")
            yield _mistake(source, place, "`share` needs samples, but the scenario has none")


def _mistake(source: Source, path: KeyPath, message: str) -> Diagnostic:
    return Diagnostic("SD102", source.key_span_of(path), message, "add `samples: 1000` to the scenario")


def _nothing_uncertain(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    if scenario.uncertain is None and all(step.jitter is None for step in scenario.build):
        message = "the scenario has no random quantities, so all samples are identical"
        hint = "add `jitter: {position: 1 mm, yaw: 1 deg}` to a step of `build`"
        yield Diagnostic("SD102", source.key_span_of(("samples",)), message, hint)


def _beyond_statics(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Yield keys that need a simulation. Samples are judged by statics alone, after each brick."""
    hint = "remove either this key or `samples`"
    if scenario.impacts:
        message = "samples are judged by statics alone, which cannot evaluate impacts"
        yield Diagnostic("SD104", source.key_span_of(("impacts",)), message, hint)
    if scenario.world.shake is not None:
        message = "samples are judged by statics alone, which cannot evaluate a shaking ground"
        yield Diagnostic("SD104", source.key_span_of(("world", "shake")), message, hint)
    for number, step in enumerate(scenario.build):
        if step.place is not None:
            message = "samples are judged by statics alone, which cannot evaluate placement by hand"
            yield Diagnostic(
                "SD104", source.key_span_of(("build", number, "place")), message, "remove `place`, and keep `jitter`"
            )
        for index, brick in enumerate(step.bricks or ()):
            if brick.drop:
                message = "samples are judged by statics alone, which cannot evaluate dropped bricks"
                yield Diagnostic("SD104", source.key_span_of(("build", number, "bricks", index, "drop")), message, hint)


def _of_one_run(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for key, number, claim in _claims(scenario):
        if claim.content.wanted_share is None:
            message = f"`{claim.kind}` without `share` applies to a single run, but the scenario has samples"
            hint = 'write, for example, stands: {share: ">= 95 %"}, or collapses: {at: level 9 ± 1, share: ">= 90 %"}'
            yield Diagnostic("SD102", source.key_span_of((key, number, claim.kind)), message, hint)


def _claims(scenario: Scenario) -> Iterator[tuple[str, int, Claim]]:
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            yield key, number, claim
