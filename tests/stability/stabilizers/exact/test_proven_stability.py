"""Exact stabilizer on a scripted engine of boxes, and in a foreign PyBullet world."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from dataclasses import dataclass, field

import pybullet
import pytest

from stability.engines.protocol import Engine
from stability.engines.pybullet import PyBulletBodies
from stability.geometry.box import Box
from stability.model import GROUND, BodyId, BodyState, ContactPoint, HalfSpace, Plane, Pose, Shape, Vec3
from stability.problem import Placed, Stability, Stage, Verdict
from stability.stabilizers.exact.stabilizer import ProvenStability
from stability.stabilizers.protocol import Update

STEP = 0.01  # [s]
PLANK = (0.12, 0.024, 0.008)  # [m]
GROUND_PLANE = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction=0.5)


@dataclass
class BoxEngine(Engine):
    """Planks that stay where the test puts them."""

    bricks: dict[BodyId, BodyState] = field(default_factory=dict)
    planes: dict[BodyId, BodyState] = field(default_factory=lambda: {"ground": BodyState(Pose((0.0, 0.0, 0.0)))})
    shapes: dict[BodyId, Shape] = field(default_factory=lambda: {"ground": HalfSpace((0.0, 0.0, 1.0))})
    touching: dict[BodyId, list[BodyId]] = field(default_factory=dict)  # bodies that are no bricks
    frozen: set[BodyId] = field(default_factory=set)
    clock: float = 0.0

    def time(self) -> float:
        return self.clock

    def masses(self) -> Mapping[BodyId, float]:
        return dict.fromkeys(self.bricks, 0.012)

    def fixed(self) -> Set[BodyId]:
        return self.planes.keys()

    def shape(self, body: BodyId) -> Shape:
        return self.shapes.get(body, Box(PLANK))

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return sorted({*self.bricks, *self.planes, *self.touching.get(brick, ())} - {brick})

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        return {body: self.bricks.get(body) or self.planes[body] for body in bodies}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        up = (0.0, 0.0, 1.0)
        return [ContactPoint(brick, other, (0.0, 0.0, 0.0), up, 0.0) for other in self.touching.get(brick, ())]

    def holds(self, brick: BodyId) -> bool:
        return brick in self.frozen

    def freeze(self, brick: BodyId) -> None:
        self.frozen.add(brick)

    def wake(self, brick: BodyId) -> None:
        self.frozen.remove(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self.bricks[brick] = BodyState(pose)

    def put(self, name: BodyId, level: int, x: float = 0.0, velocity: Vec3 = (0.0, 0.0, 0.0)) -> None:
        """A plank along x, or back where it was with another state."""
        self.bricks[name] = BodyState(Pose((x, 0.0, 0.008 * (level - 0.5))), velocity)


def set_down(engine: BoxEngine, stability: ProvenStability, **at: tuple[int, float]) -> Update:
    for name, (level, x) in at.items():
        engine.put(name, level, x)
    stability.set_down(at)
    return stability.update()


def counterweighted(engine: BoxEngine, stability: ProvenStability) -> Update:
    """Four bricks of equal mass: com above a lies 10 mm inside its end with d, and 15 mm outside without d."""
    #    |d|      |c|
    #    |---beam---|
    # |----a----|
    engine.shapes |= {"c": Box((0.02, 0.024, 0.008)), "d": Box((0.02, 0.024, 0.008))}
    return set_down(engine, stability, a=(1, 0.0), beam=(2, 0.05), c=(3, 0.1), d=(3, 0.0))


def after(engine: BoxEngine, stability: ProvenStability, seconds: float = 2 * STEP) -> Update:
    """Return the update after a duration."""
    last = Update()
    for _ in range(round(seconds / STEP)):
        engine.clock += STEP
        update = stability.update()
        last = update if update != Update() else last
    return last


@pytest.fixture
def engine() -> BoxEngine:
    return BoxEngine()


@pytest.fixture
def stability(engine: BoxEngine) -> ProvenStability:
    return ProvenStability(engine)


def test_bricks_set_down_together_are_judged_together_before_any_step(
    engine: BoxEngine, stability: ProvenStability
) -> None:
    assert counterweighted(engine, stability).frozen == ("a", "beam", "c", "d")
    assert engine.frozen == {"a", "beam", "c", "d"}
    verdict = stability.verdict()
    assert verdict is not None
    assert verdict.stability is Stability.STABLE
    assert stability.least_margin() is None


def test_a_frozen_brick_says_which_stage_proved_it(engine: BoxEngine, stability: ProvenStability) -> None:
    assert set_down(engine, stability, a=(1, 0.0)).proof == Stage.LOAD_CORE
    assert stability.shares() == {"a": {"ground": pytest.approx(1.0)}}
    assert stability.shares(["a", "b"]) == stability.shares()


def test_a_frozen_brick_names_the_stage_of_its_proof_when_another_is_refused(
    engine: BoxEngine, stability: ProvenStability
) -> None:
    update = set_down(engine, stability, a=(1, 0.0), b=(2, 0.0), out=(3, 0.1))
    assert update.frozen == ("a", "b")
    assert update.proof == "load core"


def test_tipping_bricks_wake_and_the_others_stay_frozen(engine: BoxEngine, stability: ProvenStability) -> None:
    #         |--c--|      c brings com of b and c 3 mm beyond the end of a; a alone stands
    #     |--b--|
    # |--a--|
    set_down(engine, stability, a=(1, 0.0), b=(2, 0.042))
    update = set_down(engine, stability, c=(3, 0.084))
    assert update.frozen == ()
    assert update.woken == ("b", "c")
    assert update.failed == ("b",)  # the lowest of those that move
    assert "tip" in update.reason
    assert engine.frozen == {"a"}
    assert stability.awake() == ["b", "c"]
    verdict = stability.verdict()
    assert verdict is not None
    assert verdict.stability is Stability.UNSTABLE


def test_a_brick_is_not_frozen_while_it_moves(engine: BoxEngine, stability: ProvenStability) -> None:
    engine.put("a", 1, velocity=(0.0, 0.0, -0.02))
    assert after(engine, stability).frozen == ()
    engine.put("a", 1)
    assert after(engine, stability).frozen == ("a",)


def test_candidates_carry_each_other(engine: BoxEngine, stability: ProvenStability) -> None:
    engine.put("a", 1)
    engine.put("b", 2)
    assert after(engine, stability).frozen == ("a", "b")


def test_a_brick_on_one_that_still_moves_waits_for_it(engine: BoxEngine, stability: ProvenStability) -> None:
    engine.put("a", 1, velocity=(0.02, 0.0, 0.0))
    engine.put("b", 2)
    assert after(engine, stability, 0.5).frozen == ()
    engine.put("a", 1)
    assert after(engine, stability, 0.5).frozen == ("a", "b")


def test_bricks_in_contact_with_a_robot_are_not_frozen(engine: BoxEngine, stability: ProvenStability) -> None:
    engine.touching["b"] = ["robot"]
    engine.put("a", 1)
    engine.put("b", 2)
    assert after(engine, stability).frozen == ("a",)


def test_a_body_that_is_no_box_is_never_frozen(engine: BoxEngine, stability: ProvenStability) -> None:
    engine.shapes["ball"] = None
    engine.put("ball", 1)
    assert after(engine, stability, 0.5).frozen == ()
    assert stability.awake() == ["ball"]


def test_refused_bricks_are_not_judged_again_before_a_change(
    engine: BoxEngine, stability: ProvenStability, monkeypatch: pytest.MonkeyPatch
) -> None:
    stability.update()  # looks at the ground
    asked: list[Verdict] = []
    add_all = stability.assembly.add_all

    def counted(bricks: Iterable[Placed], **how: bool) -> Verdict:
        asked.append(add_all(bricks, **how))
        return asked[-1]

    monkeypatch.setattr(stability.assembly, "add_all", counted)
    set_down(engine, stability, a=(1, 0.0), b=(2, 0.07))
    assert stability.awake() == ["b"]
    after(engine, stability, 0.5)
    assert len(asked) == 1
    engine.put("b", 2, 0.0695)  # half a millimetre back, and still beyond the end of a
    after(engine, stability, 0.5)
    assert len(asked) == 2
    engine.put("b", 2, 0.0)
    assert after(engine, stability, 0.5).frozen == ("b",)


def test_a_plank_that_comes_to_rest_on_a_frozen_one_wakes_it_if_both_fall(
    engine: BoxEngine, stability: ProvenStability
) -> None:
    set_down(engine, stability, a=(1, 0.0), b=(2, 0.042))
    engine.put("c", 3, 0.084)  # dropped there, and not announced
    assert after(engine, stability).woken == ("b",)
    assert stability.awake() == ["b", "c"]


def test_waking_a_brick_wakes_bricks_on_it(engine: BoxEngine, stability: ProvenStability) -> None:
    set_down(engine, stability, a=(1, 0.0), b=(2, 0.0), far=(1, 1.0))
    assert stability.wake(["a"]) == ("a", "b")
    assert stability.awake() == ["a", "b"]
    assert stability.is_frozen("far")


def test_a_woken_brick_is_not_frozen_again_before_it_has_been_still_for_the_hold_off(
    engine: BoxEngine, stability: ProvenStability
) -> None:
    set_down(engine, stability, a=(1, 0.0))
    stability.wake(["a"])
    assert after(engine, stability, stability.rest.hold_off - STEP).frozen == ()
    assert after(engine, stability, 1.5).frozen == ("a",)


def test_removing_a_brick_or_the_ground_wakes_bricks_on_it(engine: BoxEngine, stability: ProvenStability) -> None:
    set_down(engine, stability, a=(1, 0.0), b=(2, 0.0))
    del engine.bricks["a"]
    assert after(engine, stability, STEP).woken == ("b",)
    set_down(engine, stability, c=(1, 1.0))
    del engine.planes["ground"]
    assert after(engine, stability, STEP).woken == ("c",)


def test_a_brick_that_its_owner_pushes_is_woken_and_one_that_is_moved_is_judged_again(
    engine: BoxEngine, stability: ProvenStability
) -> None:
    set_down(engine, stability, a=(1, 0.0), b=(2, 0.0), c=(3, 0.0))
    engine.put("b", 2, 0.01)
    assert after(engine, stability, STEP) == Update()  # still under c
    engine.put("b", 2, 0.01, velocity=(0.1, 0.0, 0.0))
    assert after(engine, stability, STEP).woken == ("b", "c")
    assert engine.frozen == {"a"}


def test_taking_a_counterweight_away_wakes_the_beam_that_it_held(engine: BoxEngine, stability: ProvenStability) -> None:
    counterweighted(engine, stability)
    del engine.bricks["d"]
    assert after(engine, stability, STEP).woken == ("beam", "c")
    assert stability.is_frozen("a")


def test_removing_a_support_wakes_the_bricks_that_cannot_stand_without_it(engine: BoxEngine) -> None:
    stability = ProvenStability(engine, planes=[GROUND_PLANE], guard=False)
    counterweighted(engine, stability)
    del engine.bricks["d"]
    update = stability.taken_out(["d"])
    assert (update.frozen, update.woken, update.failed) == ((), ("beam", "c"), ("beam",))
    assert stability.is_frozen("a")
    assert stability.awake() == ["beam", "c"]
    verdict = stability.verdict()
    assert verdict is not None
    assert verdict.stability is Stability.UNSTABLE


def test_removing_a_brick_keeps_the_proof_of_bricks_that_stand_without_it(engine: BoxEngine) -> None:
    stability = ProvenStability(engine, planes=[GROUND_PLANE], guard=False)
    set_down(engine, stability, a=(1, 0.0), b=(2, 0.01), c=(3, 0.0))
    del engine.bricks["c"]
    assert stability.taken_out(["c"]) == Update()
    assert stability.awake() == []
    assert stability.shares() == {"a": {"ground": pytest.approx(1.0)}, "b": {"a": pytest.approx(1.0)}}


def test_a_brick_that_was_left_to_the_engine_can_be_taken_out_too(engine: BoxEngine) -> None:
    stability = ProvenStability(engine, planes=[GROUND_PLANE], guard=False)
    set_down(engine, stability, a=(1, 0.0))
    set_down(engine, stability, b=(2, 0.07))
    assert stability.awake() == ["b"]
    del engine.bricks["b"]
    assert stability.taken_out(["b"]) == Update()
    assert stability.awake() == []
    verdict = stability.verdict()
    assert verdict is not None
    assert verdict.stability is Stability.STABLE


def test_without_a_guard_an_update_does_not_check_frozen_bricks(
    engine: BoxEngine, monkeypatch: pytest.MonkeyPatch
) -> None:
    stability = ProvenStability(engine, planes=[GROUND_PLANE], guard=False)
    set_down(engine, stability, **{f"b{level}": (level, 0.0) for level in range(1, 9)})
    monkeypatch.setattr(engine, "states", lambda bodies: {body: engine.bricks[body] for body in set(bodies) & {"top"}})
    monkeypatch.setattr(engine, "holds", None)
    assert set_down(engine, stability, top=(9, 0.0)).frozen == ("top",)


# --- in a foreign world -----------------------------------------------------------------------------------------------


@contextmanager
def client_of_somebody() -> Iterator[int]:
    """A PyBullet client with ground without end, number 0, at z = 0."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setGravity(0.0, 0.0, -9.81, client)
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
        pybullet.createMultiBody(0.0, plane, physicsClientId=client)
        yield client
    finally:
        pybullet.disconnect(client)


def box(client: int, *position: float) -> int:
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.3, 0.1, 0.05], physicsClientId=client)
    return int(pybullet.createMultiBody(1.0, shape, basePosition=position, physicsClientId=client))


def stepped(bodies: PyBulletBodies, stability: ProvenStability, steps: int) -> list[BodyId]:
    woken: list[BodyId] = []
    for _ in range(steps):
        bodies.step()
        woken += stability.update().woken
    return woken


def test_dropped_boxes_settle_under_the_engine_and_are_frozen_with_a_proof() -> None:
    with client_of_somebody() as client:
        bodies = PyBulletBodies(client)
        stability = ProvenStability(bodies, friction=0.25)  # PyBullet multiplies 0.5 by 0.5
        for level in range(4):
            box(client, 0.02 * level, 0.0, 0.08 + 0.1 * level)  # 30 mm above the one below
            stepped(bodies, stability, 240)
        assert stability.awake() == []
        assert stability.assembly.verdict().stability is Stability.STABLE
        assert set(stability.shares()["4"]) == {"3"}
        pybullet.removeBody(1, client)
        assert stepped(bodies, stability, 1) == ["2", "3", "4"]
        stepped(bodies, stability, 60)
        assert bodies.states(["4"])["4"].pose.position_W[2] < 0.34


def test_a_box_given_a_velocity_flies_off_with_it() -> None:
    with client_of_somebody() as client:
        bodies = PyBulletBodies(client)
        stability = ProvenStability(bodies, friction=0.25)
        box(client, 0.0, 0.0, 0.05)
        stepped(bodies, stability, 10)
        assert stability.awake() == []
        pybullet.resetBaseVelocity(1, [0, 2, 0], physicsClientId=client)
        assert stepped(bodies, stability, 30) == ["1"]
        assert bodies.states(["1"])["1"].pose.position_W[1] > 0.1
