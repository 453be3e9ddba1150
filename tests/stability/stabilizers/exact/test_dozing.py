"""Bricks at rest on bricks without a proof are held by the engine, and change no motion."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from stability.engines.rigid.world import RigidWorld
from stability.geometry.box import Box
from stability.model import GROUND, BodyId, BodyState, Brick, Plane, Pose
from stability.problem import Placed, Tolerances
from stability.stabilizers.exact.dozing import Dozing
from stability.stabilizers.exact.woken_region import DeadLoads
from stability.stabilizers.rest import LimitsBySize, RestLimits
from stackdsl.api.cases import load
from stackdsl.api.run import play
from stackdsl.simulation.systems import RIGID

GRAVITY, FRICTION = 9.81, 0.5
FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION)
TABLE, LEVER, WEIGHT = (
    Placed(Brick("table", Box((0.2, 0.1, 0.1)), 1.0), Pose((0.0, 0.0, 0.05))),
    Placed(Brick("lever", Box((0.2, 0.05, 0.01)), 0.1), Pose((0.12, 0.0, 0.105))),
    Placed(Brick("weight", Box((0.02, 0.05, 0.02)), 0.2), Pose((0.03, 0.0, 0.12))),
)


def standing(*bricks: Placed) -> tuple[RigidWorld, Dozing]:
    """Return a world in which a table stands and these bricks have come to rest, and none dozes."""
    world = RigidWorld.opened(RIGID, GRAVITY, FRICTION)
    world.add_plane(FLOOR)
    for placed in (TABLE, *bricks):
        world.add_brick(placed.brick, placed.pose)
    world.freeze("table")
    for _ in range(20):
        world.step()
    limits, loads = LimitsBySize(world, RestLimits()), DeadLoads(world, world)
    return world, Dozing(world, limits, loads, FRICTION, GRAVITY, Tolerances())


def height(world: RigidWorld, brick: BodyId) -> float:
    return world.states([brick])[brick].pose.position_W[2]


def test_a_counterweight_that_dozes_holds_down_its_lever() -> None:
    # Seen from the edge, the weight turns the lever by 0.2 * 0.07 kg m, and its own mass the other way by 0.1 * 0.02.
    world, dozing = standing(LEVER, WEIGHT)
    dozing.fall_asleep([WEIGHT], (), [FLOOR])
    assert list(dozing) == ["weight"]
    for _ in range(300):
        dozing.loads.exert()
        world.step()
    assert height(world, "lever") == pytest.approx(0.105, abs=2e-5)


def test_a_lever_without_its_counterweight_tips() -> None:
    world, dozing = standing(LEVER)
    dozing.fall_asleep([LEVER], (), [FLOOR])
    assert not dozing, "statics finds no forces that hold it"
    for _ in range(300):
        world.step()
    assert height(world, "lever") < 0.1


def test_a_brick_on_a_moving_brick_does_not_doze() -> None:
    _, dozing = standing(LEVER, WEIGHT)
    dozing.fall_asleep([WEIGHT], {"lever"}, [FLOOR])
    assert not dozing


@pytest.mark.parametrize(("moved", "wakes"), [(0.00003, False), (0.00007, True)])
def test_a_dozing_brick_wakes_when_what_it_lies_on_moves_by_a_two_hundredth_of_its_thickness(
    moved: float, wakes: bool
) -> None:
    world, dozing = standing(LEVER, WEIGHT)
    dozing.fall_asleep([WEIGHT], (), [FLOOR])
    x, y, z = world.states(["lever"])["lever"].pose.position_W
    world.put_at("lever", Pose((x + moved, y, z)))
    assert dozing.disturbed(world.states(["lever"])) == (["weight"] if wakes else [])


def test_what_dozes_on_a_removed_brick_wakes() -> None:
    world, dozing = standing(LEVER, WEIGHT)
    dozing.fall_asleep([WEIGHT], (), [FLOOR])
    dozing.removed(["lever"])
    assert not dozing
    assert not world.holds("weight")


CHAIN = """
scenario: chain
build: [{dominoes: {bricks: 36, spacing: 30 mm}}]
impacts: [{at: 0 s, push: {brick: L1.1, impulse: [2 mN*s, 0 N*s, 0 N*s], point: [0 mm, 0 mm, 50 mm]}}]
watch: 3 s
systems: [exact]
expect: [{falls: {count: 36}}]
"""


def test_fallen_dominoes_doze_behind_the_wave_and_end_where_they_end_without_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "chain.yaml"
    file.write_text(CHAIN)
    (case,) = load(file)
    most, disturbed = 0, Dozing.disturbed

    def counted(dozing: Dozing, states: Mapping[BodyId, BodyState]) -> list[BodyId]:
        nonlocal most
        most = max(most, len(dozing))
        return disturbed(dozing, states)

    monkeypatch.setattr(Dozing, "disturbed", counted)
    with_it = play(case)
    monkeypatch.setattr(Dozing, "is_due", lambda *_: False)
    without = play(case)
    assert most >= 5
    assert with_it.passed
    assert without.passed
    # A push that is stronger by a millionth moves the last dominoes by as much, 0.3 mm.
    places, places_without = (run.arrays()["final"][:, :3] for run in (with_it, without))
    np.testing.assert_allclose(places, places_without, rtol=0.0, atol=0.001)
