"""`${...}`: arithmetic with units over the variables of `let:` and `matrix:`, done before validation.

An expression is split into tokens here; only Python's grammar is borrowed to group them, and nothing is evaluated by
Python. Values are exact fractions, so that `floor(0.3 m / 0.1 m)` is 3. Roots and sines are kept to 15 digits, so that
`floor(2 * sin(30 deg))` is 1.
"""

# Pint leaves its operators untyped.
# mypy: disable-error-code="no-any-return"

import ast
import keyword
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, Final, TypeAlias, cast

from stackdsl.diagnostics import Diagnostic, did_you_mean
from stackdsl.quantities import NUMBER, UNIT, UNITS, MistakeError, registry, shown, unit_amount
from stackdsl.source import MAX_EXACT, Path, Plain, Source

if TYPE_CHECKING:
    from stackdsl.quantities import Amount

    # None stands for a variable whose own line is mistaken: what uses it is left as written.
    Names: TypeAlias = Mapping[str, Amount | None]

# A mistake may turn up once a variant: where it is and what it says make it one.
Mistakes: TypeAlias = dict[tuple[Path, str], MistakeError]

FIXED: Final = ("scenario", "let", "matrix")  # what is not filled in like the rest
MAX_LENGTH: Final = 160  # [characters] of an expression
MAX_BITS: Final = 1000  # of numerator and denominator; any such fraction is a finite double
MAX_POWER: Final = 64
MAX_VARIANTS: Final = 256

PI: Final = Fraction("3.14159265358979323846264338327950288")
ROUNDINGS: Final = {
    "floor": math.floor,
    "ceil": math.ceil,
    "round": lambda value: math.floor(value + Fraction(1, 2)),  # not half to even, which surprises: 2.5 gives 3
}
WAVES: Final = {"sin": math.sin, "cos": math.cos, "tan": math.tan}
ROUNDOFF: Final = 1e-15  # what a sine of a right angle may be wrong by
CHOICES: Final = {"min": min, "max": max}
FUNCTIONS: Final = (*ROUNDINGS, *CHOICES, *WAVES, "abs", "sqrt")
NOUNS: Final = {
    "": "a number",
    "m": "a length",
    "s": "a duration",
    "rad": "an angle",
    "kg": "a mass",
    "m/s": "a speed",
    "m/s2": "an acceleration",
    "kg/m3": "a density",
}  # fmt: skip -- a table

_EXPRESSION = re.compile(r"\$\{([^{}]*)\}")
_CONSTANT = re.compile(rf"(?P<number>[+-]?{NUMBER})\s*(?P<unit>{UNIT})?")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_TOKEN = re.compile(
    rf"\s*(?:(?P<literal>{NUMBER})\s*(?P<unit>{UNIT})(?!\s*\()|(?P<number>{NUMBER})(?![\w.])"
    rf"|(?P<name>{_NAME.pattern})|(?P<operator>\*\*|[-+*/(),]))\s*"
)


class _EarlierMistakeError(Exception):
    """The value cannot be known, for reasons already told."""


class _NameError(MistakeError):
    """The name of a variable is at fault, not its value."""


def _mistake(message: str, hint: str = "") -> MistakeError:
    return MistakeError("SD109", message, hint)


# --- variants ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Variant:
    """A scenario with its variables filled in."""

    parameters: tuple[tuple[str, str], ...]  # the choice from each row of `matrix`, as written
    values: dict[str, Plain]


def expand(source: Source) -> tuple[tuple[Variant, ...], tuple[Diagnostic, ...]]:
    """One variant for each combination of `matrix`, in the author's order, and the mistakes of all expressions.

    A value whose expression is mistaken stays as written, so that the rest of its variant can still be validated.
    """
    axes, mistakes = _axes(source.values.get("matrix", {}))
    variants = []
    for choice in product(*axes.values()):
        variant, more = _variant(source.values, dict(zip(axes, choice, strict=True)))
        variants.append(variant)
        mistakes |= more
    found = {_diagnostic(source, path, mistake) for (path, _), mistake in mistakes.items()}
    return tuple(variants), tuple(sorted(found, key=reading_order))


def _diagnostic(source: Source, path: Path, mistake: MistakeError) -> Diagnostic:
    span = source.key_span_of(path) if isinstance(mistake, _NameError) else source.span_of(path)
    return Diagnostic(mistake.code, span, mistake.message, mistake.hint)


def reading_order(diagnostic: Diagnostic) -> tuple[int, int, str, str]:
    """Sorts diagnostics of one file by place, then by what they say."""
    return diagnostic.span.line, diagnostic.span.column, diagnostic.code, diagnostic.message


def _variant(values: dict[str, Plain], choice: dict[str, Plain]) -> tuple[Variant, Mistakes]:
    """One combination of the matrix, filled in; a row that is mistaken has the value None."""
    rows = {name: None if written is None else _constant(written) for name, written in choice.items()}
    names, lets, mistakes = _let(values.get("let", {}), rows)
    name = values.get("scenario")
    if isinstance(name, str) and "${" in name:
        fixed = _mistake("the name of a scenario cannot vary", "variants are told apart by their values of the matrix")
        mistakes |= _at(("scenario",), fixed)
    body = {key: value for key, value in values.items() if key not in FIXED}
    filled = {key: _filled(value, (key,), names) for key, value in body.items()}
    found = _merged(found for _, found in filled.values())
    changed = {"let": lets, **{key: value for key, (value, _) in filled.items()}}
    parameters = tuple((name, str(written)) for name, written in choice.items() if written is not None)
    return Variant(parameters, {key: changed.get(key, value) for key, value in values.items()}), mistakes | found


def _axes(matrix: Plain) -> tuple[dict[str, list[Plain]], Mistakes]:
    """The rows of `matrix`; a mistaken one has the single value None."""
    if not isinstance(matrix, dict):
        return {}, _at(("matrix",), MistakeError("SD103", "expected a mapping", "write {step: [10 mm, 12 mm]}"))
    found = {name: _row_mistakes(name, row) for name, row in matrix.items()}
    mistakes = _merged(found.values())
    axes: dict[str, list[Plain]] = {
        name: row if isinstance(row, list) and not found[name] else [None] for name, row in matrix.items()
    }
    count = math.prod(len(row) for row in axes.values())
    if count <= MAX_VARIANTS:
        return axes, mistakes
    message = f"the matrix has {count} combinations, and {MAX_VARIANTS} are the most"
    return {name: [None] for name in axes}, mistakes | _at(("matrix",), MistakeError("SD206", message))


def _row_mistakes(name: str, row: Plain) -> Mistakes:
    path: Path = ("matrix", name)
    try:
        _check_name(name)
    except MistakeError as mistake:
        return _at(path, mistake)
    if not isinstance(row, list) or not row:
        return _at(path, MistakeError("SD103", "expected a list of values", "write [10 mm, 12 mm]"))
    mistakes: Mistakes = {}
    for index, written in enumerate(row):
        try:
            _constant(written)
            if written in row[:index]:
                raise MistakeError("SD104", f"{shown(written)} is in the row already", "write each value once")
        except MistakeError as mistake:
            mistakes |= _at((*path, index), mistake)
    return mistakes


def _let(let: Plain, rows: "Names") -> tuple["Names", Plain, Mistakes]:
    """All variables; `let` with their values in place of its expressions; and its mistakes."""
    if not isinstance(let, dict):
        return rows, let, _at(("let",), MistakeError("SD103", "expected a mapping", "write {length: 120 mm}"))
    names, lets, mistakes = dict(rows), dict(let), _merged(())
    for name, written in let.items():
        filled, found = _filled(written, ("let", name), names)
        names[name], lets[name] = None, filled
        try:
            _check_name(name, rows)
            if not (isinstance(filled, str) and "${" in filled):
                names[name] = _constant(filled)
        except MistakeError as mistake:
            found |= _at(("let", name), mistake)
        mistakes |= found
    return names, lets, mistakes


def _check_name(name: str, taken: Iterable[str] = ()) -> None:
    if not _NAME.fullmatch(name) or keyword.iskeyword(name):
        raise _NameError("SD109", f"'{name}' cannot name a variable", "write letters, digits and _, a letter first")
    if name in UNITS or name in FUNCTIONS or name == "pi":
        raise _NameError("SD109", f"'{name}' is a unit or a function, not a variable", "take a longer name")
    if name in taken:
        raise _NameError("SD109", f"'{name}' is a variable of the matrix already", "take another name")


def _constant(written: Plain) -> "Amount":
    """A number or a quantity, written without an expression."""
    text = str(written) if isinstance(written, int | float) and not isinstance(written, bool) else written
    match = _CONSTANT.fullmatch(text.strip()) if isinstance(text, str) else None
    if match is None:
        raise _mistake(f"{shown(written)} is neither a number nor a quantity", "write such as 12, 13.5 mm, or ${2 * n}")
    return _bounded(unit_amount(match["unit"] or "") * Fraction(match["number"]))


def _filled(value: Plain, path: Path, names: "Names") -> tuple[Plain, Mistakes]:
    """A value with its expressions worked out, save those with mistakes."""
    if isinstance(value, dict):
        members = {key: _filled(member, (*path, key), names) for key, member in value.items()}
        return {key: member for key, (member, _) in members.items()}, _merged(found for _, found in members.values())
    if isinstance(value, list):
        items = [_filled(item, (*path, index), names) for index, item in enumerate(value)]
        return [item for item, _ in items], _merged(found for _, found in items)
    if not isinstance(value, str) or "${" not in value:
        return value, {}
    try:
        return interpolate(value, names), {}
    except MistakeError as mistake:
        return value, _at(path, mistake)
    except _EarlierMistakeError:
        return value, {}


def _at(path: Path, mistake: MistakeError) -> Mistakes:
    return {(path, mistake.message): mistake}


def _merged(many: Iterable[Mistakes]) -> Mistakes:
    return {key: mistake for mistakes in many for key, mistake in mistakes.items()}


# --- one expression ---------------------------------------------------------------------------------------------------


def interpolate(text: str, names: "Names") -> int | float | str:
    """Text with its expressions worked out; a number if it is one expression and that a number."""
    whole = _EXPRESSION.fullmatch(text.strip())
    if whole:
        return _plain(evaluate(whole[1], names))
    if "${" in _EXPRESSION.sub("", text):
        raise _mistake(f"{shown(text)} has an expression without an end", "close it by }; braces do not nest")
    return _EXPRESSION.sub(lambda match: str(_plain(evaluate(match[1], names))), text)


def evaluate(expression: str, names: "Names") -> "Amount":
    """The value of what stands between `${` and `}`."""
    if len(expression) > MAX_LENGTH:  # which also keeps its nesting far from Python's limits
        raise _mistake(f"the expression is longer than {MAX_LENGTH} characters", "split it by variables of `let`")
    grouped, literals = _grouped(expression)
    try:
        tree = ast.parse(f"({grouped})", mode="eval")
    except SyntaxError as error:
        raise _mistake(f"cannot read the expression '{expression.strip()}'", "write such as 2 * (n + 1)") from error
    return _value(tree.body, {**names, **literals})


def _grouped(expression: str) -> tuple[str, "dict[str, Amount]"]:
    """The tokens, numbers and quantities replaced by names that no variable can have; and what these stand for."""
    tokens: list[str] = []
    literals: dict[str, Amount] = {}
    position, after = 0, None
    while position < len(expression):
        token = _TOKEN.match(expression, position)
        if token is None:
            raise _mistake(f"cannot read the expression at '{expression[position:].strip()}'")
        if after and token["name"]:
            raise _mistake(f"'{token['name']}' is not a unit", did_you_mean(token["name"], tuple(UNITS)))
        if after and after["unit"] and token["operator"] == "**":
            raise _mistake(f"'{after[0].strip()} **' can be read in two ways", f"write ({after[0].strip()}) **")
        number = token["literal"] or token["number"]
        if number:
            literals[f"_{len(tokens)}"] = _bounded(unit_amount(token["unit"] or "") * Fraction(number))
        tokens.append(f"_{len(tokens)}" if number else token["name"] or token["operator"])
        position, after = token.end(), token if number else None
    return " ".join(tokens), literals


def _value(node: ast.expr, names: "Names") -> "Amount":
    """The value of a tree; whatever is not listed here is refused."""
    match node:
        case ast.Name(id=name):
            return _variable(name, names)
        case ast.UnaryOp(op=ast.USub() | ast.UAdd() as sign, operand=operand):
            return _value(operand, names) * (-1 if isinstance(sign, ast.USub) else 1)
        case ast.BinOp(left=left, op=operator, right=right):
            return _bounded(_operation(operator, _value(left, names), _value(right, names)))
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
            return _bounded(_call(name, [_value(argument, names) for argument in arguments]))
    raise _mistake("the expression is not plain arithmetic", f"use + - * / ** ( ) and {', '.join(FUNCTIONS)}")


def _variable(name: str, names: "Names") -> "Amount":
    if name == "pi":
        return unit_amount("") * PI
    if name not in names:
        known = [known for known in names if not known.startswith("_")]
        raise _mistake(f"unknown variable '{name}'", did_you_mean(name, known) or "define it above, under `let`")
    amount = names[name]
    if amount is None:
        raise _EarlierMistakeError
    return amount


def _operation(operator: ast.operator, left: "Amount", right: "Amount") -> "Amount":
    match operator:
        case ast.Mult():
            return left * right
        case ast.Div() if right.magnitude == 0:
            raise _mistake("division by zero")
        case ast.Div():
            return left / right
        case ast.Pow():
            return _power(left, right)
    if left.units != right.units:
        verb = "add" if isinstance(operator, ast.Add) else "subtract"
        raise _mistake(f"cannot {verb} {_noun(left)} and {_noun(right)}")
    return left + right if isinstance(operator, ast.Add) else left - right


def _power(base: "Amount", exponent: "Amount") -> "Amount":
    power = _number(exponent, "an exponent")
    if power.denominator != 1 or abs(power) > MAX_POWER:
        raise _mistake(f"an exponent is a whole number up to {MAX_POWER}", "for roots there is sqrt")
    if base.magnitude == 0 and power < 0:
        raise _mistake("division by zero")
    return base ** int(power)


def _call(name: str, values: "list[Amount]") -> "Amount":
    if name not in FUNCTIONS:
        raise _mistake(f"unknown function '{name}'", did_you_mean(name, FUNCTIONS))
    if name in CHOICES:
        if not values or any(value.units != values[0].units for value in values):
            raise _mistake(f"{name} takes values of one kind", f"write such as {name}(10 mm, width)")
        return CHOICES[name](values, key=lambda value: value.magnitude)
    if len(values) != 1:
        raise _mistake(f"{name} takes one value, not {len(values)}")
    if name == "abs":
        return abs(values[0])
    if name in ROUNDINGS:
        return unit_amount("") * Fraction(ROUNDINGS[name](_number(values[0], f"the value of {name}")))
    return _root(values[0]) if name == "sqrt" else _wave(name, values[0])


def _root(value: "Amount") -> "Amount":
    if value.magnitude < 0:
        raise _mistake("the root of a negative value")
    root = Fraction(f"{math.sqrt(value.magnitude):.15g}")
    return registry().Quantity(root, value.units ** Fraction(1, 2))


def _wave(name: str, angle: "Amount") -> "Amount":
    if _unit_text(angle) != "rad":
        raise _mistake(f"{name} takes an angle, not {_noun(angle)}", f"write such as {name}(30 deg)")
    wave = WAVES[name](float(angle.magnitude))
    if abs(wave) > 1 / ROUNDOFF:
        raise _mistake("the tangent of a right angle")
    # The cosine of 90 deg is 6e-17 in floats; 15 digits alone would keep it.
    return unit_amount("") * (Fraction(f"{wave:.15g}") if abs(wave) > ROUNDOFF else 0)


# --- amounts ----------------------------------------------------------------------------------------------------------


def _number(amount: "Amount", role: str) -> Fraction:
    if _unit_text(amount):
        raise _mistake(f"{role} is a number, not {_noun(amount)}", "divide by a quantity of the same kind")
    return amount.magnitude


def _bounded(amount: "Amount") -> "Amount":
    if max(amount.magnitude.numerator.bit_length(), amount.magnitude.denominator.bit_length()) > MAX_BITS:
        raise _mistake("a number grows too large or too fine")
    return amount


def _noun(amount: "Amount") -> str:
    unit = _unit_text(amount)
    return NOUNS.get(unit, f"a quantity in {unit}")


def _unit_text(amount: "Amount") -> str:
    """The unit in SI, such as `kg/m3`; empty for a number."""
    powers = sorted(cast("Iterable[tuple[str, Fraction]]", amount.unit_items()))
    above = [name if power == 1 else f"{name}{power}" for name, power in powers if power > 0]
    below = [f"/{name}" if power == -1 else f"/{name}{-power}" for name, power in powers if power < 0]
    return "*".join(above) + "".join(below)


def _plain(amount: "Amount") -> int | float | str:
    """A number, whole if it can be, or the text of a quantity in SI that reads back to the same double."""
    unit, magnitude = _unit_text(amount), amount.magnitude
    if unit:
        return f"{float(magnitude)!r} {unit}"
    return int(magnitude) if magnitude.denominator == 1 and abs(magnitude) < MAX_EXACT else float(magnitude)
