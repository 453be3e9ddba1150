"""Who carries a brick, as a bare engine's contact forces say: the measure of `rests_on` where no model answers it."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from stability.model import BodyId, ContactPoint

UPWARD = 0.5  # z of a contact normal towards the carried brick; steeper touches are at its side
NOTHING = 1e-3  # a support that takes less than this share is touched, not rested on


@dataclass
class ForceMeter:
    """Sums what each brick was pressed up with by each other body. Engines scatter load, so average over many steps."""

    upward: dict[BodyId, dict[BodyId, float]] = field(default_factory=lambda: defaultdict(lambda: defaultdict(float)))

    def add(self, brick: BodyId, contacts: Iterable[ContactPoint]) -> None:
        """Take in the contacts of a brick in one step: those that press it up."""
        for point in contacts:
            other, z = (point.b, point.normal_BA_W[2]) if point.a == brick else (point.a, -point.normal_BA_W[2])
            if z >= UPWARD:
                self.upward[brick][other] += point.normal_force * z

    def shares(self, bricks: Iterable[BodyId]) -> Mapping[BodyId, Mapping[BodyId, float]]:
        """The supports of these bricks and their shares."""
        return {brick: self._shares(self.upward.get(brick, {})) for brick in bricks}

    def _shares(self, forces: Mapping[BodyId, float]) -> Mapping[BodyId, float]:
        total = sum(forces.values())
        return {on: force / total for on, force in forces.items() if force > NOTHING * total} if total > 0.0 else {}
