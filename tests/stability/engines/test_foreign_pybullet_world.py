"""Stabilizers in a foreign PyBullet world: unsupported shapes, and gravity."""

import warnings
from collections.abc import Callable, Iterator

import pybullet
import pybullet_data  # type: ignore[import-untyped]
import pytest

from stability import Plane, ProvenStability, PyBulletBodies, StackStability, UnknownShapeWarning

Stepped = Callable[[PyBulletBodies, ProvenStability], None]


@pytest.fixture
def client() -> Iterator[int]:
    """A client with gravity as on the Earth, and nothing in it."""
    number = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0.0, 0.0, -9.81, number)
    yield number
    pybullet.disconnect(number)


def ground(client: int) -> None:
    shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
    pybullet.createMultiBody(0.0, shape, physicsClientId=client)


def brick(client: int, z: float, **placed: object) -> str:
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=[0.3, 0.1, 0.05], physicsClientId=client, **placed
    )
    return str(pybullet.createMultiBody(1.0, shape, basePosition=[0, 0, z], physicsClientId=client))


def ball(client: int, x: float, mass: float = 1.0) -> str:
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1, physicsClientId=client)
    return str(pybullet.createMultiBody(mass, shape, basePosition=[x, 0, 0.1], physicsClientId=client))


def play(bodies: PyBulletBodies, stability: ProvenStability, steps: int = 60) -> None:
    for _ in range(steps):
        bodies.step()
        stability.update()


def test_only_the_first_ball_raises_a_warning(client: int) -> None:
    ground(client)
    balls = [ball(client, x) for x in (0.0, 1.0, 2.0)]
    bodies = PyBulletBodies(client)
    with pytest.warns(UnknownShapeWarning) as told:
        play(bodies, stability := ProvenStability(bodies, friction=0.25))
    assert stability.awake() == balls
    (one,) = told
    assert "unsupported shape of brick '1': a GEOM_SPHERE" in str(one.message)


def test_fixed_ground_of_unsupported_shape_raises_a_warning_with_a_remedy(client: int) -> None:
    ball(client, 0.0, mass=0.0)
    top = brick(client, 0.25)
    bodies = PyBulletBodies(client)
    with pytest.warns(UnknownShapeWarning, match="unsupported shape of fixed body '0': a GEOM_SPHERE.*`planes=`"):
        play(bodies, stability := ProvenStability(bodies, friction=0.25))
    assert stability.awake() == [top]


def test_a_brick_with_an_offset_mass_raises_a_warning(client: int) -> None:
    ground(client)
    brick(client, 0.05, collisionFramePosition=[0.02, 0, 0])
    bodies = PyBulletBodies(client)
    with pytest.warns(UnknownShapeWarning, match="offset from the origin of its frame"):
        play(bodies, ProvenStability(bodies, friction=0.25))


def test_boxes_on_the_ground_of_plane_urdf_are_proven_to_stand(client: int) -> None:
    pybullet.loadURDF(f"{pybullet_data.getDataPath()}/plane.urdf", physicsClientId=client)
    bricks = [brick(client, 0.05), brick(client, 0.15)]
    bodies = PyBulletBodies(client)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        play(bodies, stability := ProvenStability(bodies, friction=0.25))
    assert stability.awake() == []
    assert set(stability.shares()[bricks[1]]) == {bricks[0]}


def test_gravity_is_that_of_the_engine(client: int) -> None:
    pybullet.setGravity(0.0, 0.0, -1.62, client)
    assert ProvenStability(PyBulletBodies(client)).assembly.gravity == pytest.approx(1.62)


@pytest.mark.parametrize("method", [ProvenStability, StackStability])
@pytest.mark.parametrize(
    ("of_the_engine", "given", "message"),
    [
        ((0.0, 0.0, 0.0), None, "no gravity; set it first"),
        ((1.0, 0.0, -9.81), None, r"\(1, 0, -9.81\) m/s2, but proofs require gravity along -z"),
        ((0.0, 0.0, 9.81), None, "require gravity along -z"),
        ((0.0, 0.0, -1.62), 9.81, "gravity=9.81 differs from the gravity of the engine, 1.62 m/s2"),
    ],
)
def test_unsupported_gravity_is_rejected(
    method: Callable[..., object],
    of_the_engine: tuple[float, float, float],
    given: float | None,
    message: str,
    client: int,
) -> None:
    pybullet.setGravity(*of_the_engine, client)
    with pytest.raises(ValueError, match=message):
        method(PyBulletBodies(client), gravity=given)


def test_a_caller_that_applies_weights_passes_the_gravity(client: int) -> None:
    pybullet.setGravity(0.0, 0.0, 0.0, client)
    assert ProvenStability(PyBulletBodies(client), gravity=3.7).assembly.gravity == 3.7


def test_a_later_change_of_gravity_is_rejected(client: int) -> None:
    bodies = PyBulletBodies(client)
    play(bodies, stability := ProvenStability(bodies, planes=[Plane("floor", (0, 0, 0), (0, 0, 1), 0.5)]), steps=1)
    pybullet.setGravity(0.0, 0.0, -1.62, client)
    with pytest.raises(ValueError, match="has changed"):
        play(bodies, stability, steps=1)
