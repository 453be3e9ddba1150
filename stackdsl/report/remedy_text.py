"""What would let a scenario stand that falls, a line a remedy."""

from collections.abc import Collection, Iterator
from math import inf

from stability.model import BodyId
from stability.name_order import in_order
from stackdsl.judging.remedies import HeavierBrick, MoreFriction, OtherNumber, Remedies
from stackdsl.wording import names_text

NO_COUNTERWEIGHT = "no counterweight on one brick was found"
KILOGRAM = 1.0  # [kg] from which on a mass is told in kg


def remedy_lines(remedies: Remedies) -> Iterator[str]:
    """All of them, and what is proven not to help."""
    found = list(map(_number, remedies.numbers))
    found += [friction_text(remedies.friction)] if remedies.friction is not None else []
    found += [counterweight_text(remedies.counterweight)] if remedies.counterweight is not None else []
    yield from found
    if not remedies.numbers:
        yield "no number of the file by itself, of those that were tried"
    if remedies.counterweight is None:
        yield "no counterweight on a brick is enough: none rises" if remedies.nothing_rises else NO_COUNTERWEIGHT


def _number(remedy: OtherNumber) -> str:
    knob, limit = remedy.knob, remedy.limit
    sign = ">=" if limit.least else "<="
    return f"{knob.name} {sign} {knob.text(limit.value)}, in place of {knob.text(knob.number)} at {knob.span}"


def friction_text(remedy: MoreFriction) -> str:
    if remedy.factor == inf:
        return "no friction is enough"
    if remedy.alike:
        return f"friction >= {remedy.coefficient:.4g}"
    return f"every friction times {remedy.factor:.4g}, of brick on brick {remedy.coefficient:.4g}"


def counterweight_text(remedy: HeavierBrick) -> str:
    mass = f"{remedy.mass:.4g} kg" if remedy.mass >= KILOGRAM else f"{1000.0 * remedy.mass:.4g} g"
    return f"{mass} on {remedy.brick}, at its centre{later_text(remedy.next_to_fall)}"


def later_text(next_to_fall: Collection[BodyId]) -> str:
    """What a remedy does not help."""
    return f"; later {names_text(in_order(next_to_fall))} would fall" if next_to_fall else ""
