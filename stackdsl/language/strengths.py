"""Strength of a kind of brick against crushing."""

from dataclasses import replace
from functools import partial
from typing import Annotated

from pydantic import Field

from stability.strength import Strength
from stackdsl.language import value_types as t
from stackdsl.language.model_base import AtLeastOneKey
from stackdsl.language.quantities import FORCE, MASS, STRENGTH, quantity_pattern

_MASS = replace(MASS, example="120 kg")
_FORCE = replace(FORCE, positive=True, example="1200 N")
StackLoad = Annotated[
    float,
    t.Reads(
        partial(t.read_weighed, mass=_MASS, force=_FORCE, noun="a load"),
        t.text_schema(
            rf"{quantity_pattern(MASS)}|{quantity_pattern(FORCE)}", "a load as a mass or a force", _MASS.example
        ),
    ),
]
Pressure = Annotated[float, t.quantity(replace(STRENGTH, positive=True))]  # [Pa]


class BrickStrength(AtLeastOneKey):
    """Strength of a brick against crushing."""

    pressure: Pressure | None = Field(None, description="greatest pressure at any place of a face in contact")
    stack: StackLoad | None = Field(
        None, description="greatest load that may lie on the brick, as a mass or a force, such as 120 kg"
    )

    def under(self, gravity: float) -> Strength:
        """Return the strength in SI units, at a gravity [m/s2]."""
        limits = {"pressure": self.pressure, "stack": self.stack}
        if isinstance(self.stack, t.Weighed):
            limits["stack"] = gravity * self.stack
        return Strength(**{key: value for key, value in limits.items() if value is not None})
