"""Expressions `${...}` with units, and ranges of values."""

import ast
import math
import re
from collections import ChainMap
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from typing import TYPE_CHECKING, Final, TypeAlias, cast

from stackdsl.diagnostics import did_you_mean
from stackdsl.language.quantities import (
    ALSO_VARIABLES,
    NUMBER,
    QUANTITY,
    REMEMBERED,
    UNIT,
    UNITS,
    InputError,
    in_si,
    number_remedy,
    quantity_text,
    range_remedy,
    registry,
    shown,
    unit_amount,
)
from stackdsl.language.yaml.parsing import MAX_EXACT
from stackdsl.language.yaml.source import Plain

if TYPE_CHECKING:
    from stackdsl.language.quantities import Amount


# Expressions `${...}`: arithmetic with units over the variables of a scenario, done before validation.
#
# An expression is split into tokens here. Python's parser only builds the tree; Python evaluates nothing. Values are
# exact fractions, so that `floor(0.3 m / 0.1 m)` is 3. Roots and sines are rounded to 15 digits, so that
# `floor(2 * sin(30 deg))` is 1.


# Pint leaves its operators untyped.
# mypy: disable-error-code="no-any-return"


if TYPE_CHECKING:
    Value: TypeAlias = Amount | str  # a number, a quantity, or a word
    # None stands for a variable with a mistaken definition: expressions that use it stay as written.
    Names: TypeAlias = Mapping[str, Value | None]


def inner_names(own: "Names", around: "Names") -> "Names":
    """Return an inner scope over the scope around it. Nothing is copied, since scopes and names may be many."""
    return ChainMap(cast("dict[str, Value | None]", own), cast("dict[str, Value | None]", around))


MAX_LENGTH: Final = 160  # [characters] of an expression
MAX_BITS: Final = 1000  # of numerator and denominator, so that every fraction is a finite double
MAX_POWER: Final = 64

PI: Final = Fraction("3.14159265358979323846264338327950288")
ROUNDINGS: Final = {
    "floor": math.floor,
    "ceil": math.ceil,
    "round": lambda value: math.floor(value + Fraction(1, 2)),  # half up, as users expect, not half to even: 2.5 -> 3
}
WAVES: Final = {"sin": math.sin, "cos": math.cos, "tan": math.tan}
ROUNDOFF: Final = 1e-15  # largest error of the sine or cosine of a right angle
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

MARK: Final = "_"
PLAIN: Final = f"use numbers, quantities, variables, + - * / ** ( ) and {', '.join(FUNCTIONS)}"
REMEDIES: Final = {
    "^": "write a power with `**`, as in n ** 2",
    "%": "write a percentage as 5 percent, and the remainder of n / 2 as n - 2 * floor(n / 2)",
    **dict.fromkeys("<>=!", "expressions have no comparisons or assignments; use `matrix` for several values"),
    **dict.fromkeys("\"'", "expressions cannot contain quoted text; write the name of a brick without ${}"),
    "_": "begin the name of a variable with a letter",
}

_EXPRESSION = re.compile(r"\$\{([^{}]*)\}")
_CONSTANT = re.compile(rf"(?P<number>[+-]?{NUMBER})\s*(?P<unit>{UNIT})?")
VARIABLE: Final = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
WORD: Final = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,63}")  # such as `kapla`, `L3.2` or `tuned`
_TOKEN = re.compile(
    rf"\s*(?:(?P<literal>{NUMBER})\s*(?P<unit>{UNIT})(?!\s*\()|(?P<number>{NUMBER})(?![\w.])"
    rf"|(?P<name>{VARIABLE.pattern})|(?P<operator>\*\*|[-+*/(),]))\s*"
)


class EarlierInputError(Exception):
    """The value is unknown because of a mistake that is reported already."""


def _mistake(message: str, hint: str | Callable[[], str] = "") -> InputError:
    return InputError("SD109", message, hint)


def interpolate(text: str, names: "Names") -> int | float | str:
    """Evaluate the expressions in a text. A text that is one numeric expression becomes a number."""
    single = _EXPRESSION.fullmatch(text.strip())
    if single:
        return _plain_value(single[1], names)
    if "${" in _EXPRESSION.sub("", text):
        raise _mistake(f"an expression in {shown(text)} is not closed", "close it with }; braces cannot be nested")
    return _EXPRESSION.sub(lambda match: str(_plain_value(match[1], names)), text)


def _plain_value(expression: str, names: "Names") -> int | float | str:
    """Evaluate an expression to a number or a text. A variable that is a word may only stand alone."""
    value = names.get(expression.strip())
    return value if isinstance(value, str) else _plain(evaluate(expression, names))


def variables_in(text: str) -> set[str]:
    """Return the names in the expressions of a text, including units and functions."""
    return {name for expression in _EXPRESSION.findall(text) for name in VARIABLE.findall(expression)}


_NOTATION: Final = re.compile(r"[${}<>]")  # of expressions in other languages: $n, {n}, {{n}}, <n>


def meant_expression(written: object, names: Collection[str]) -> str:
    """Return a text that is meant as an expression of some of these variables, in `${}`; empty if it is not."""
    text = written.strip() if isinstance(written, str) and len(written) <= MAX_LENGTH else ""
    bare = _NOTATION.sub("", text).strip()
    if "${" in text or not any(name in names for name in VARIABLE.findall(bare)):
        return ""
    try:
        evaluate(bare, dict.fromkeys(names))
    except EarlierInputError:  # it is well-formed, and the values of the variables are irrelevant
        return f"${{{bare}}}"
    except InputError:
        with_braces = re.sub(rf"\$({VARIABLE.pattern})", r"${\1}", text)
        return with_braces if with_braces != text else ""
    return ""


def evaluate(expression: str, names: "Names") -> "Amount":
    """Evaluate the text between `${` and `}`."""
    tree, literals = _parsed(expression)
    return _value(tree, inner_names(literals, names) if literals else names)


@lru_cache(maxsize=REMEMBERED)
def _parsed(expression: str) -> "tuple[ast.expr, Mapping[str, Amount]]":
    """Return the tree of an expression, and its literals by their placeholder names in the tree."""
    if len(expression) > MAX_LENGTH:  # also keeps the nesting far below Python's limits
        raise _mistake(
            f"the expression is longer than {MAX_LENGTH} characters", "split it into several variables under `let`"
        )
    grouped, literals = _grouped(expression)
    try:
        tree = ast.parse(f"({grouped})", mode="eval")
    except SyntaxError as error:
        raise _mistake(f"cannot read the expression '{expression.strip()}'", PLAIN) from error
    return tree.body, literals


def _grouped(expression: str) -> tuple[str, "dict[str, Amount]"]:
    """Return the tokens and the literals of an expression.

    Names are marked; numbers and quantities are replaced by placeholder names that no variable can have.
    """
    tokens: list[str] = []
    literals: dict[str, Amount] = {}
    position, after = 0, None
    if not expression.strip():
        raise _mistake("the expression is empty", "write, for example, ${2 * (n + 1)}")
    while position < len(expression):
        token = _TOKEN.match(expression, position)
        if token is None:
            rest = expression[position:].strip()
            raise _mistake(f"cannot read the expression at '{rest}'", REMEDIES.get(rest[:1], PLAIN))
        if after and token["name"]:
            raise _mistake(f"'{token['name']}' is not a unit", did_you_mean(token["name"], tuple(UNITS)))
        if after and after["unit"] and token["operator"] == "**":
            raise _mistake(
                f"'{after[0].strip()} **' is ambiguous", f"write ({after[0].strip()}) ** to raise the whole quantity"
            )
        number = token["literal"] or token["number"]
        if number:
            literals[f"_{len(tokens)}"] = _bounded(unit_amount(token["unit"] or "") * Fraction(number))
        # The mark at the end of a name allows variables that are reserved words of Python, such as `from`.
        tokens.append(f"_{len(tokens)}" if number else token["name"] + MARK if token["name"] else token["operator"])
        position, after = token.end(), token if number else None
    return " ".join(tokens), literals


def _value(node: ast.expr, names: "Names") -> "Amount":
    """Evaluate a tree. Only the node types listed here are allowed."""
    match node:
        case ast.Name(id=name):
            return _variable(name.removesuffix(MARK), names)
        case ast.UnaryOp(op=ast.USub() | ast.UAdd() as sign, operand=operand):
            return _value(operand, names) * (-1 if isinstance(sign, ast.USub) else 1)
        case ast.BinOp(left=left, op=operator, right=right):
            return _bounded(_operation(operator, _value(left, names), _value(right, names)))
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
            return _bounded(_call(name.removesuffix(MARK), [_value(argument, names) for argument in arguments]))
    raise _mistake("the expression contains more than arithmetic", PLAIN)


def _variable(name: str, names: "Names") -> "Amount":
    if name == "pi":
        return unit_amount("") * PI
    if name not in names:
        define, message = "define it under `let`, above this place", f"unknown variable '{name}'"
        known = [each for each in names if each[0] != "_" and each != name]
        raise _mistake(message, lambda: did_you_mean(name, known) or define)
    value = names[name]
    if value is None:
        raise EarlierInputError
    if isinstance(value, str):
        raise _mistake(
            f"the value of '{name}' is the word '{value}', not a number",
            f"write ${{{name}}} without further arithmetic",
        )
    return value


def _with_unit(*operands: "Amount") -> str:
    """Return the remedy for operands of different units: the number of two with the unit of the other."""
    numbers = [each for each in operands if not unit_text(each)]
    unit = next((unit_text(each) for each in operands if unit_text(each)), "")
    if len(numbers) != 1:
        return "use the same kind of unit for both"
    number = f"{float(numbers[0].magnitude):g}"
    return f"write {number} {_USUAL.get(unit, unit)} in place of {number}"


_USUAL: Final = {"m": "mm", "rad": "deg"}  # units of numbers in expressions


def _operation(operator: ast.operator, left: "Amount", right: "Amount") -> "Amount":
    match operator:
        case ast.Mult():
            return left * right
        case ast.Div() if right.magnitude == 0:
            raise _mistake("division by zero", "change the divisor so that it is never 0")
        case ast.Div():
            return left / right
        case ast.Pow():
            return _power(left, right)
    if left.units != right.units:
        verb = "add" if isinstance(operator, ast.Add) else "subtract"
        raise _mistake(f"cannot {verb} {_noun(left)} and {_noun(right)}", _with_unit(left, right))
    return left + right if isinstance(operator, ast.Add) else left - right


def _power(base: "Amount", exponent: "Amount") -> "Amount":
    power = _number(exponent, "an exponent")
    if power.denominator != 1 or abs(power) > MAX_POWER:
        raise _mistake(
            f"an exponent must be an integer from -{MAX_POWER} to {MAX_POWER}", "use sqrt() for square roots"
        )
    if base.magnitude == 0 and power < 0:
        raise _mistake("division by zero", "change the base so that it is never 0")
    return base ** int(power)


def _call(name: str, values: "list[Amount]") -> "Amount":
    if name not in FUNCTIONS:
        raise _mistake(f"unknown function '{name}'", did_you_mean(name, FUNCTIONS))
    if name in CHOICES:
        if not values or any(value.units != values[0].units for value in values):
            raise _mistake(
                f"all arguments of {name} must have the same kind of unit", f"write, for example, {name}(10 mm, width)"
            )
        return CHOICES[name](values, key=lambda value: value.magnitude)
    if len(values) != 1:
        raise _mistake(f"{name} takes one argument, not {len(values)}", f"write, for example, {name}(n)")
    if name == "abs":
        return abs(values[0])
    if name in ROUNDINGS:
        return unit_amount("") * Fraction(ROUNDINGS[name](_number(values[0], f"the argument of {name}")))
    return _root(values[0]) if name == "sqrt" else _wave(name, values[0])


def _root(value: "Amount") -> "Amount":
    if value.magnitude < 0:
        raise _mistake("the argument of sqrt is negative", "make the argument non-negative, for example with abs()")
    root = Fraction(f"{math.sqrt(value.magnitude):.15g}")
    return registry().Quantity(root, value.units ** Fraction(1, 2))


def _wave(name: str, angle: "Amount") -> "Amount":
    if unit_text(angle) != "rad":
        raise _mistake(f"{name} takes an angle, not {_noun(angle)}", f"write, for example, {name}(30 deg)")
    # Subtract whole turns while the angle is exact: a large angle would lose digits as a float.
    turns = round(angle.magnitude / (2 * PI)) if abs(angle.magnitude) > 2 * PI else 0
    wave = WAVES[name](float(angle.magnitude - turns * 2 * PI))
    if abs(wave) > 1 / ROUNDOFF:
        raise _mistake("the tangent of 90 deg is undefined", "change the angle so that it is never 90 deg")
    # The cosine of 90 deg is 6e-17 in floats, which rounding to 15 digits does not remove.
    return unit_amount("") * (Fraction(f"{wave:.15g}") if abs(wave) > ROUNDOFF else 0)


# --- amounts ----------------------------------------------------------------------------------------------------------


def constant(written: Plain, hint: str = "write, for example, 12 or 13.5 mm") -> "Amount":
    """Read a number or a quantity without expressions."""
    text = str(written) if isinstance(written, int | float) and not isinstance(written, bool) else written
    amount = _amount(text.strip()) if isinstance(text, str) else None
    if amount is None:
        raise _mistake(f"{shown(written)} is neither a number nor a quantity", number_remedy(text) or hint)
    return amount


@lru_cache(maxsize=REMEMBERED)
def _amount(text: str) -> "Amount | None":
    """Read a number or a quantity; return None if the text is neither."""
    match = _CONSTANT.fullmatch(text)
    return None if match is None else _bounded(unit_amount(match["unit"] or "") * Fraction(match["number"]))


def value_of(
    written: Plain, known: "Iterable[str]" = (), hint: str = "write, for example, 12, 13.5 mm, or kapla"
) -> "Value":
    """Read the value of a variable: a number, a quantity, or a word that is not one of the `known` names."""
    word = written.strip() if isinstance(written, str) else ""
    if not WORD.fullmatch(word):
        if "${" in word:
            hint = "write plain values here, and define expressions of them under `let`"
        return constant(written, hint)
    if word in known:
        raise _mistake(f"'{word}' is the name of a variable, not a value", f"write ${{{word}}}")
    if word in UNITS.keys() - ALSO_VARIABLES or word in FUNCTIONS or word == "pi":
        raise _mistake(
            f"'{word}' is a reserved word of expressions", "write a quantity, for example 1 mm, or another word"
        )
    return word


def _number(amount: "Amount", role: str) -> Fraction:
    if unit_text(amount):
        raise _mistake(f"{role} must be a number, not {_noun(amount)}", "divide it by a quantity with the same unit")
    return amount.magnitude


def _bounded(amount: "Amount") -> "Amount":
    if max(amount.magnitude.numerator.bit_length(), amount.magnitude.denominator.bit_length()) > MAX_BITS:
        raise _mistake("a number becomes too large, or has too many digits", "use smaller exponents or fewer digits")
    return amount


def _noun(amount: "Amount") -> str:
    return NOUNS.get(unit := unit_text(amount), f"a quantity in {unit}")


def unit_text(amount: "Amount") -> str:
    """Return the SI unit of an amount, such as `kg/m3`; empty for a number."""
    powers = sorted(cast("Iterable[tuple[str, Fraction]]", amount.unit_items()))
    above = [name if power == 1 else f"{name}{power}" for name, power in powers if power > 0]
    below = [f"/{name}" if power == -1 else f"/{name}{-power}" for name, power in powers if power < 0]
    return "*".join(above) + "".join(below)


def _plain(amount: "Amount") -> int | float | str:
    """Return an int if possible, a float, or the text of a quantity that reads back to the same double."""
    unit, magnitude = unit_text(amount), amount.magnitude
    if unit:
        # A computed mass in grams would be read as multiples of gravity where an acceleration is expected.
        return quantity_text(magnitude, unit, everyday=unit != "kg")
    return int(magnitude) if magnitude.denominator == 1 and abs(magnitude) < MAX_EXACT else float(magnitude)


# Ranges and lists of values: `1 .. 18`, `5 mm .. 15 mm by 0.5 mm`, `[10 mm, 12 mm]`.


_RANGE: Final = re.compile(r"(?P<first>.+?)\s*\.\.\s*(?P<last>.+?)(?:\s+by\s+(?P<step>.+))?")
ROUNDING: Final = Fraction(1, 10**9)  # tolerance on the end of a range, in steps, for rounding in expressions
LONGEST_DECIMAL: Final = 20  # digits after the decimal point, the same limit as in `NUMBER`
_ADVICE: Final = "write, for example, [10 mm, 12 mm], 1 .. 18, or 5 mm .. 15 mm by 0.5 mm"


def values_of(written: Plain, most: int) -> list[Plain]:
    """Return the values of a range or a list, each as written in YAML.

    Raises InputError, SD206 for more than `most` values, before the values of a range are made.
    """
    remedy = range_remedy(written) if isinstance(written, str) else ""
    if isinstance(written, str) and not remedy and (match := _RANGE.fullmatch(written.strip())):
        return list(_between(match, written, most))
    if not isinstance(written, list) or not written:
        what = "an empty list" if written == [] else shown(written)
        listed = f"write [{written}]" if isinstance(written, int | float) or "," in str(written) else ""
        raise InputError("SD103", f"expected a list of values or a range, not {what}", remedy or listed or _ADVICE)
    _check_count(most, len(written), "the list")
    return written


def _between(match: re.Match[str], written: str, most: int) -> Iterator[Plain]:
    parts = {key: _part(part, written) for key, part in match.groupdict().items() if part is not None}
    first, last = parts["first"], parts["last"]
    if first.units != last.units or parts.get("step", first).units != first.units:
        raise InputError(
            "SD106",
            f"the parts of the range {shown(written)} have different units",
            "use the same kind of unit for all parts",
        )
    if "step" not in parts and not first.dimensionless:
        raise InputError(
            "SD102",
            f"the range {shown(written)} has a unit but no step",
            f"write, for example, {written} by 1 {_unit(match)}",
        )
    step: Fraction = parts["step"].magnitude if "step" in parts else Fraction(1)
    if step == 0 or (last.magnitude - first.magnitude) / step < 0:
        raise InputError(
            "SD104",
            f"the step of the range {shown(written)} does not lead to its last value",
            "write a negative step for a descending range, for example 18 .. 1 by -1",
        )
    steps = (last.magnitude - first.magnitude) / step
    count = round(steps)
    if abs(steps - count) > ROUNDING:
        ends = _text(first.magnitude + int(steps) * step, _unit(match))
        message = f"the steps of the range {shown(written)} end at {ends}, not at its last value"
        raise InputError("SD104", message, "change the last value or the step so that the range ends at its last value")
    _check_count(most, count + 1, f"the range {shown(written)}")
    yield from (_text(first.magnitude + index * step, _unit(match)) for index in range(count + 1))


def _part(part: str, written: str) -> "Amount":
    try:
        return constant(part)
    except InputError as mistake:
        raise InputError("SD103", f"the range {shown(written)} cannot be read at '{part}'", _ADVICE) from mistake


def _check_count(most: int, count: int, noun: str) -> None:
    if count > most:
        message = f"{noun} has {count} values; the maximum is {most}"
        raise InputError("SD206", message, "write fewer values, or a larger step")


def _unit(match: re.Match[str]) -> str:
    """Return the unit of the first part of a range that has one."""
    units = (part["unit"] for text in match.groups() if text and (part := QUANTITY.fullmatch(text.strip())))
    return next(filter(None, units), "")


def _text(magnitude: Fraction, unit: str) -> Plain:
    """Format an SI magnitude in a unit; return a number if the unit is empty."""
    number = magnitude / in_si(unit)
    decimal = f"{Decimal(number.numerator) / number.denominator:.{LONGEST_DECIMAL}f}".rstrip("0").rstrip(".")
    if not unit:
        return int(number) if number.denominator == 1 else float(number)
    return f"{decimal} {unit}" if Fraction(decimal) == number else quantity_text(magnitude, unit)


def value_mistakes(values: list[Plain]) -> Iterator[tuple[int, InputError]]:
    """Yield index and mistake of each invalid or repeated value of a list; `10 mm` and `1 cm` are the same value."""
    seen: set[object] = set()
    for index, written in enumerate(values):
        try:
            is_range = isinstance(written, str) and _RANGE.fullmatch(written) is not None
            value = (
                value_of(written, hint="write a range without brackets around it") if is_range else value_of(written)
            )
        except InputError as mistake:
            yield index, mistake
            continue
        if value in seen:
            yield (
                index,
                InputError("SD104", f"the list contains {shown(written)} twice", "write each value once"),
            )
        seen.add(value)
