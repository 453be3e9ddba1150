"""Direct hits of the published method: by bricks outside the stack, predicted, once each."""

from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from stability.engines.pybullet import PyBulletWorld
from stability.geometry.box import Box
from stability.model import BodyId, Brick, Plane, Pose, Vec3
from stability.stabilizers.published.impacts import DirectHits
from stability.stabilizers.rest import RestLimits
from stackdsl.simulation.systems import HELD

CUBE = 0.02  # [m]
GROUND = Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)


@dataclass
class Scene:
    """A frozen cube at the origin, and others at some distance from it along x."""

    world: PyBulletWorld
    hits: DirectHits

    def put(self, name: BodyId, gap: float, velocity_W: Vec3) -> None:
        pose = Pose((CUBE + gap, 0.0, CUBE / 2.0))
        self.world.add_brick(Brick(name, Box((CUBE, CUBE, CUBE)), 0.01), pose, velocity_W)

    def coming(self) -> list[tuple[BodyId, BodyId]]:
        awake = sorted(self.world.masses().keys() - {"target"})
        return [(hit.by, hit.brick) for hit in self.hits.coming(awake, {"target"})]

    def hits_of_a_step(self) -> list[tuple[BodyId, BodyId]]:
        self.world.step()
        return self.coming()


@pytest.fixture
def scene() -> Iterator[Scene]:
    world = PyBulletWorld.opened(HELD, 9.81, friction=0.5, heaviest=0.01)
    found = Scene(world, DirectHits(world, RestLimits()))
    found.put("target", -CUBE, (0.0, 0.0, 0.0))
    world.freeze("target")
    found.hits.frozen(["target"])
    yield found
    world.close()


def test_a_hit_is_predicted_with_the_speed_of_the_flight(scene: Scene) -> None:
    scene.put("shot", 0.001, (-1.0, 0.0, 0.5))
    (hit,) = scene.hits.coming(["shot"], {"target"})
    assert (hit.by, hit.brick) == ("shot", "target")
    assert hit.velocity_W == pytest.approx((-1.0, 0.0, 0.5))


@pytest.mark.parametrize(
    ("gap", "velocity_W"),
    [
        (0.030, (-1.0, 0.0, 0.0)),  # far away: 30 steps
        (0.001, (1.0, 0.0, 0.0)),  # flies away
        (0.001, (0.0, 1.0, 0.0)),  # flies past
        (0.001, (-0.004, 0.0, 0.0)),  # within the limits of rest
    ],
)
def test_distant_slow_or_passing_bricks_are_no_direct_hits(scene: Scene, gap: float, velocity_W: Vec3) -> None:
    scene.put("shot", gap, velocity_W)
    assert scene.coming() == []


def test_a_hit_is_reported_once_per_approach(scene: Scene) -> None:
    scene.put("shot", 0.001, (-1.0, 0.0, 0.0))
    assert scene.coming() == [("shot", "target")]
    scene.world.step()
    assert scene.coming() == []


def test_a_brick_that_has_parted_may_hit_again(scene: Scene) -> None:
    scene.put("shot", 0.004, (-1.0, 0.0, 0.0))
    told = [scene.hits_of_a_step() for _ in range(20)]
    assert [hit for hits in told for hit in hits] == [("shot", "target")]  # it has lain beside the target since
    for impulse in (0.01, -0.02):  # away, and back
        at = scene.world.states(["shot"])["shot"].pose.position_W
        scene.world.push("shot", (impulse, 0.0, 0.0), at)
        told = [scene.hits_of_a_step() for _ in range(10)]
    assert [hit for hits in told for hit in hits] == [("shot", "target")]


def test_bricks_of_the_stack_are_no_direct_hits(scene: Scene) -> None:
    scene.hits.frozen(["shot"])
    scene.put("shot", 0.001, (-1.0, 0.0, 0.0))
    assert scene.coming() == []


def test_another_brick_of_the_same_name_is_a_stranger(scene: Scene) -> None:
    scene.hits.frozen(["shot"])
    scene.hits.removed(["shot"])
    scene.put("shot", 0.001, (-1.0, 0.0, 0.0))
    assert scene.coming() == [("shot", "target")]
