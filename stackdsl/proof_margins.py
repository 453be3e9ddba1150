"""What a proof survives, as far as somebody asked."""

from dataclasses import dataclass

from stability.model import BodyId
from stability.statics.margins.weakest import Weakest


@dataclass(frozen=True, slots=True)
class Margins:
    """What a proof survives: each None where nobody asked for it, or where nothing is proven to stand."""

    acceleration: float | None = None  # the least horizontal acceleration that brings it down, by bearing [g]
    bearing: float | None = None  # of that acceleration, from +x towards +y [rad]
    tilt: float | None = None  # the least tilt of the whole that brings it down [rad]
    friction: float | None = None  # the least Coulomb coefficient of the roughest contact, all in proportion
    roughest: float | None = None  # what that contact has
    placement: float | None = None  # how far every brick may be placed beside where it is [m]
    joint: tuple[BodyId, BodyId] | None = None  # the contact that limits `placement`, lower body first
    guaranteed: bool | None = None  # whether rest is the only thing that can happen, rather than one that can
    certainty: str = ""  # why, in words; empty where normal forces alone balance everything
    squeezed: bool | None = None  # whether the others count on contacts that may be pressed together, or may not
    weakest: Weakest | None = None  # the mechanism that opens first under the least acceleration
