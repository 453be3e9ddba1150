"""The numbers of a scenario that can be varied, and the timeline of the scenario with another value for one of them.

Variables of `let` and `matrix` come first, then parameters of layouts, the tilt of the scene, coefficients of friction,
and positions of bricks that were placed one by one. Times are left out: no structure stands because a step comes later.
"""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Final

from stability.model import BodyId
from stackdsl.compiler.bricks import EarlierBricks, bricks_of
from stackdsl.compiler.compile import compile_timeline
from stackdsl.compiler.schedule import planes_of
from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.language.distributions import distributions, named
from stackdsl.language.layouts.registry import LAYOUTS
from stackdsl.language.quantities import SIGNED, UNIT
from stackdsl.language.schema import Scenario
from stackdsl.language.validation import validate
from stackdsl.language.variants import CHOOSING, Variant, expand
from stackdsl.language.yaml.includes import definitions_of
from stackdsl.language.yaml.source import KeyPath, Plain, Source
from stackdsl.timeline import Timeline

SHARES: Final = (
    0.001,
    0.01,
    0.05,
    0.1,
    0.2,
    0.35,
    0.5,
    0.7,
    0.85,
    1.0,
    2.0,
    4.0,
    9.0,
)  # of a number: steps away from it, on both sides
COUNTS: Final = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # steps away from a whole number
REACH: Final = (0.002, 0.01, 0.03, 0.1, 0.25, 0.5, 1.0)  # of the longest side of a brick: steps of its position
EXPECTED: Final = ("expect", "truth", "xfail")
TIMES: Final = frozenset({"s", "ms", "min", "Hz"})

_NUMBER = re.compile(rf"\s*(?P<number>{SIGNED})\s*(?P<unit>{UNIT})?\s*")


@dataclass(frozen=True, slots=True)
class ScenarioNumber:
    """One number in the file."""

    name: str  # as in reports: `d`, `step`, `x of balcony.arm`
    path: KeyPath
    span: Span
    number: float
    unit: str  # as it is written; empty for a bare number
    whole: bool
    steps: Sequence[float]  # distances from `number` at which other values are tried

    def text(self, value: float) -> str:
        """Return another value as an author would write it."""
        return f"{value:.12g} {self.unit}".rstrip()

    def written(self, value: float) -> Plain:
        """Return another value as the YAML reader would give it; an uncertain number gets a table of this one value."""
        plain: Plain = self.text(value) if self.unit else (int(value) if self.whole else value)
        return {"table": [plain]} if self.path[0] == "uncertain" else plain


@dataclass(frozen=True, slots=True)
class ScenarioNumbers:
    """The numbers of one variant of a scenario."""

    scenario: Scenario
    variant: Variant

    def numbers(self, moving: Collection[BodyId]) -> Iterator[ScenarioNumber]:
        """Yield all numbers; positions only of bricks in `moving` that were placed one by one."""
        values = self.variant.written.values
        for name in self.variant.choice:
            yield from self.variable(name)
        for name, written in _members(values.get("let")):
            yield from self._number(name, ("let", name), written)
        steps = values.get("build")
        for number, step in enumerate(steps if isinstance(steps, list) else ()):
            for layout, params in _members(step):
                if layout in LAYOUTS:
                    for key, written in _members(params):
                        yield from self._number(key, ("build", number, layout, key), written)
        for path in (("world", "tilt"), ("world", "tilt", "angle")):
            yield from self._number("tilt", path, _at(values, path))
        yield from self._frictions(values)
        if self.variant.source.values == values:  # otherwise positions of bricks in the file are not their final ones
            yield from self._places(moving)

    def variables(self) -> Mapping[str, Plain]:
        """Return the value of every variable in this variant: as written, or the value of its expression."""
        values = self.variant.written.values
        spread = {} if "uncertain" not in values else dict(named(distributions(values["uncertain"], {}, {})))
        middles = {name: each.middle for name, each in spread.items()}
        return {**self.variant.choice, **middles, **dict(_members(self.variant.values.get("let")))}

    def variable(self, name: str) -> Iterator[ScenarioNumber]:
        """Yield a variable if it is a number; an uncertain one has the middle of its distribution."""
        values = self.variant.written.values
        places: tuple[KeyPath, ...] = (("matrix", name), ("uncertain", name), ("let", name))
        place = next((path for path in places if _at(values, path) is not None), ("cases",))
        path: KeyPath = place if place[0] == "uncertain" else ("let", name)
        yield from self._number(name, path, self.variables().get(name), place=place)

    def _frictions(self, values: Plain) -> Iterator[ScenarioNumber]:
        for kind, keys in _members(_at(values, ("brick_types",))):
            yield from self._number(f"friction of {kind}", ("brick_types", kind, "friction"), _at(keys, ("friction",)))
        pairs: KeyPath = ("world", "friction", "between")
        between = _at(values, pairs)
        for number, each in enumerate(between if isinstance(between, list) else ()):
            pair, path = _at(each, ("pair",)), (*pairs, number, "friction")
            named = " and ".join(map(str, pair)) if isinstance(pair, list) else ""
            yield from self._number(f"friction of {named}", path, _at(each, ("friction",)))

    def _places(self, moving: Collection[BodyId]) -> Iterator[ScenarioNumber]:
        for brick in bricks_of(self.scenario, EarlierBricks(tuple(planes_of(self.scenario)))):
            named = f"{brick.within}.{brick.name}" if brick.within and brick.name is None else brick.name
            written_at = (*brick.path, "at") in self.variant.source.value_spans  # otherwise relative to another brick
            if named in moving and not brick.of_layout and not brick.inserted and written_at:
                for axis, letter in enumerate("xy"):
                    path = (*brick.path, "at", axis)
                    steps = [share * brick.shape.length for share in REACH]
                    yield from self._number(f"{letter} of {named}", path, _at(self.variant.written.values, path), steps)

    def _number(
        self, name: str, path: KeyPath, written: Plain, metres: Sequence[float] = (), place: KeyPath = ()
    ) -> Iterator[ScenarioNumber]:
        """Yield the number at a path, unless it is a time, an expression, or no number at all."""
        match = _NUMBER.fullmatch(str(written)) if isinstance(written, str | int | float) else None
        if match is None or isinstance(written, bool) or TIMES & set(re.findall("[A-Za-z]+", match["unit"] or "")):
            return
        number, unit = float(match["number"]), match["unit"] or ""
        whole = not unit and number == int(number)
        steps = _counts(number) if whole else [share * abs(number) for share in SHARES]
        if metres:
            scale = {"m": 1.0, "cm": 100.0, "mm": 1000.0}.get(unit)
            steps = [scale * step for step in metres] if scale else []
        if steps and (whole or metres or number):
            yield ScenarioNumber(name, path, self.variant.written.span_of(place or path), number, unit, whole, steps)

    def timeline(self, number: ScenarioNumber, value: float) -> Timeline | None:
        """Return the timeline with another value; None if the scenario is then invalid."""
        return self.compiled(number, value)[0]

    def compiled(self, number: ScenarioNumber, value: float) -> tuple[Timeline | None, Sequence[Diagnostic]]:
        """Return the timeline with another value, or the diagnostics if the scenario is then invalid."""
        source = self._chosen()
        _put(source.values, number.path, number.written(value))
        variants, diagnostics = expand(source)
        if diagnostics or len(variants) != 1:
            return None, diagnostics
        (variant,) = variants
        scenario, diagnostics = validate(variant.source, variant)
        return (None, diagnostics) if scenario is None or diagnostics else compile_timeline(scenario, variant.source)

    def _chosen(self) -> Source:
        """Return the scenario as written, with the varying variables fixed by `let`; all of them may be unused.

        Expectations are left out, as they may contradict another number of levels.
        """
        written = self.variant.written
        left_out = (*CHOOSING, *EXPECTED)
        values: dict[str, Plain] = deepcopy({key: part for key, part in written.values.items() if key not in left_out})
        lets = {**self.variant.choice, **dict(_members(values.get("let")))}
        if lets:
            values["let"] = lets
        return replace(written, values=values, inherited=written.inherited.union(definitions_of(values)))


def _counts(number: float) -> Sequence[float]:
    """Return distances at which whole numbers are tried; one of them leads down to 1."""
    return sorted({*COUNTS, *([number - 1.0] if number > 1.0 else [])})


def _members(value: Plain) -> Sequence[tuple[str, Plain]]:
    return list(value.items()) if isinstance(value, dict) else []


def _at(value: Plain, path: KeyPath) -> Plain:
    """Return the value at a path; None if there is none."""
    for key in path:
        if isinstance(value, dict) and isinstance(key, str):
            value = value.get(key)
        elif isinstance(value, list) and isinstance(key, int) and key < len(value):
            value = value[key]
        else:
            return None
    return value


def _put(value: Plain, path: KeyPath, written: Plain) -> None:
    *outer, last = path
    inner = _at(value, tuple(outer))
    assert isinstance(inner, dict | list)
    inner[last] = written  # type: ignore[index]  # a key of a mapping, or an index of a list
