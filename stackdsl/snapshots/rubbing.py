"""Who rubs otherwise than most, as a golden file tells it, and back: one value a key, in an order of its own."""

from collections.abc import Mapping

from stability.friction_law import Friction, GivenFriction, Rule
from stackdsl.snapshots.record import FRICTION, Number

RULE, OWN, PAIR, KIND = "rule", "own ", "pair ", "kind "


def rubbing_of(friction: GivenFriction) -> Mapping[str, Number | str] | None:
    """What is told beside the usual coefficient; None where that is all."""
    if not isinstance(friction, Friction):
        return None
    told: dict[str, Number | str] = {KIND + brick: kind for brick, kind in friction.kinds.items()}
    told |= {OWN + name: round(own, FRICTION.digits) for name, own in friction.own.items()}
    told |= {
        PAIR + "/".join(sorted(pair)): round(between, FRICTION.digits) for pair, between in friction.between.items()
    }
    return {RULE: str(friction.rule), **dict(sorted(told.items()))}


def friction_told(usual: float, told: object) -> GivenFriction:
    """The friction of a scene of which this is told. Raises ValueError where it means nothing."""
    if not isinstance(told, Mapping):
        return usual
    own: dict[str, float] = {}
    between: dict[tuple[str, str], float] = {}
    kinds: dict[str, str] = {}
    for key, value in told.items():
        if key.startswith(OWN):
            own[key.removeprefix(OWN)] = float(value)
        elif key.startswith(KIND):
            kinds[key.removeprefix(KIND)] = str(value)
        elif key.startswith(PAIR):
            one, other = key.removeprefix(PAIR).split("/")
            between[one, other] = float(value)
    return Friction(usual, own, between, kinds, Rule(told.get(RULE, Rule.LOWER)))
