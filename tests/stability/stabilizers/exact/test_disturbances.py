"""Hits that are reported, and hits that friction absorbs."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from stability.geometry.box import Box
from stability.model import BodyId, BodyState, ConvexShape, Pose
from stability.stabilizers.approach import Hit
from stability.stabilizers.exact.hits import Disturbances
from stability.stabilizers.rest import RestLimits
from tests.planks import GRAVITY, MASS, SIZE, column, standing


@dataclass
class BesideATable:
    """An engine with planks and a table, of which only planks have a mass."""

    poses: Mapping[BodyId, Pose]

    def masses(self) -> Mapping[BodyId, float]:
        return {name: MASS for name in self.poses if name != "table"}

    def shape(self, name: BodyId) -> ConvexShape:
        return Box((1.0, 1.0, 1.0) if name == "table" else SIZE)

    def neighbours(self, name: BodyId, within: float) -> list[BodyId]:
        return sorted(self.poses)

    def states(self, names: Iterable[BodyId]) -> Mapping[BodyId, BodyState]:
        return {name: BodyState(self.poses[name]) for name in names}


def test_a_hit_on_a_plank_beside_a_table_is_judged_as_any_other() -> None:
    poses = column(20)
    x, y, z = poses["L1"].position_W
    aside = Pose((x, y + 0.03, z))
    engine = BesideATable({**poses, "shot": aside, "table": Pose((0.0, 1.0, -0.5))})
    disturbances = Disturbances(engine, lambda brick: RestLimits(), GRAVITY, dict)  # type: ignore[arg-type]
    slow, fast = (Hit("shot", "L1", speed, (0.0, -1.0, 0.0)) for speed in (0.05, 2.0))
    assembly = standing(poses)
    assert disturbances._is_absorbed(assembly, slow, BodyState(aside, (0.0, -0.05, 0.0)))
    assert not disturbances._is_absorbed(assembly, fast, BodyState(aside, (0.0, -2.0, 0.0)))
