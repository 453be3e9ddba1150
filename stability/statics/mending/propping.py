"""The fewest props with which a build stands that falls: after each brick that is set down or pulled out, to the end.

What stands with some props stands with more, as none of them has to press. So only what falls is asked again.
"""

from dataclasses import dataclass

from stability.model import BodyId
from stability.name_order import in_order
from stability.statics.facts import Stability
from stability.statics.mending.piling import Piling
from stability.statics.orders.building import least_props
from stability.statics.orders.descent import Known, nobody
from stability.statics.orders.parts import Part, Parts
from stability.statics.orders.props import props_of


@dataclass(frozen=True, slots=True)
class Propping:
    """Supports that stay, one a brick."""

    bricks: tuple[BodyId, ...]
    next_to_fall: tuple[BodyId, ...] = ()  # later, where no props hold that; empty if everything stands


def propping(piling: Piling, known: Known = nobody) -> Propping | None:
    """The fewest props with which all of it stands, or what falls first; None if none are found.

    `known` is told how many verdicts were asked.
    """
    whole = piling.whole()
    parts = Parts(whole, props_of(whole))
    states = [parts.part_of(there) for there in piling.states()]
    first = next((turn for turn, part in enumerate(states) if not _stands(parts, part)), None)
    if first is None:
        return None
    found = least_props(parts, states[:first:-1] + states[first : first + 1], known)
    if found:
        return Propping(tuple(in_order(found)))
    found = least_props(parts, states[first : first + 1], known)
    if not found:
        return None
    last = next(part for part in states[first:] if not _stands(parts, part))
    fall = parts.ask(last).fall
    return Propping(tuple(in_order(found)), tuple(parts.names_of(fall.moving)) if fall is not None else ())


def _stands(parts: Parts, part: Part) -> bool:
    return parts.ask(part).stability is Stability.STABLE
