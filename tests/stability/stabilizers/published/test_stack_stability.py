"""Published stabilizer on a scripted engine: freezing and waking of bricks."""

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field

import pytest

from stability.engines.protocol import Engine
from stability.model import BodyId, BodyState, ContactPoint, Pose, Shape, Vec3
from stability.stabilizers.protocol import Update
from stability.stabilizers.published.stabilizer import StackStability

HALF = 0.05  # half the length of a brick [m]
STEP = 0.01  # [s]
AT_ORIGIN = BodyState(Pose((0.0, 0.0, 0.0)))


@dataclass
class ScriptedEngine(Engine):
    """Bricks of 0.1 m in a plane; contacts are written down by the test."""

    bricks: dict[BodyId, BodyState] = field(default_factory=dict)
    touching: dict[BodyId, list[ContactPoint]] = field(default_factory=dict)
    frozen: set[BodyId] = field(default_factory=set)
    immovable: set[BodyId] = field(default_factory=lambda: {"ground"})
    unlisted: set[BodyId] = field(default_factory=set)  # bodies with a state that are no bricks
    clock: float = 0.0

    def time(self) -> float:
        return self.clock

    def masses(self) -> Mapping[BodyId, float]:
        return dict.fromkeys(self.bricks.keys() - self.unlisted, 1.0)

    def fixed(self) -> Set[BodyId]:
        return self.immovable

    def shape(self, body: BodyId) -> Shape:
        return None

    def neighbours(self, brick: BodyId, within: float) -> Sequence[BodyId]:
        return sorted({point.b for point in self.touching.get(brick, [])})

    def states(self, bodies: Collection[BodyId]) -> Mapping[BodyId, BodyState]:
        return {body: self.bricks.get(body, AT_ORIGIN) for body in bodies}

    def contacts(self, brick: BodyId) -> Sequence[ContactPoint]:
        return self.touching.get(brick, [])

    def holds(self, brick: BodyId) -> bool:
        return brick in self.frozen

    def freeze(self, brick: BodyId) -> None:
        self.frozen.add(brick)

    def wake(self, brick: BodyId) -> None:
        self.frozen.remove(brick)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        self.bricks[brick] = BodyState(pose)

    def place(self, name: BodyId, x: float, on: BodyId, overlap: tuple[float, float], **point: object) -> None:
        """A brick centred at x that touches `on` over an interval of x."""
        self.bricks[name] = BodyState(Pose((x, 0.0, 0.0)))
        corners: list[Vec3] = [(end, y, 0.0) for end in overlap for y in (-0.01, 0.01)]
        values: dict[str, object] = {"normal_BA_W": (0.0, 0.0, 1.0), "gap": 0.0, **point}
        self.touching[name] = [ContactPoint(name, on, corner, **values) for corner in corners]  # type: ignore[arg-type]


def after_a_step(engine: ScriptedEngine, stability: StackStability) -> Update:
    engine.clock += STEP
    return stability.update()


def settled(engine: ScriptedEngine, stability: StackStability) -> Update:
    """Two passes: a brick is tested when it has been slow from one to the next."""
    after_a_step(engine, stability)
    return after_a_step(engine, stability)


def test_a_column_is_frozen_from_the_ground_up_one_brick_a_pass() -> None:
    engine = ScriptedEngine()
    engine.place("a", 0.0, "ground", (-HALF, HALF))
    engine.place("b", 0.0, "a", (-HALF, HALF))
    stability = StackStability(engine)
    assert settled(engine, stability).frozen == ("a",)  # b touches nothing that is in the stack yet
    assert after_a_step(engine, stability).frozen == ("b",)
    assert engine.frozen == {"a", "b"}
    assert stability.awake() == []


@pytest.mark.parametrize(
    "reason",
    [
        {"gap": 0.001},
        {"gap": -0.001},
        {"normal_BA_W": (1.0, 0.0, 0.0)},
        {"normal_BA_W": (0.0, 0.0, -1.0)},
    ],
)
def test_a_point_apart_or_beside_or_above_carries_nothing(reason: Mapping[str, object]) -> None:
    engine = ScriptedEngine()
    engine.place("a", 0.0, "ground", (-HALF, HALF), **reason)
    assert settled(engine, StackStability(engine)).frozen == ()


def test_a_brick_with_its_centre_beside_its_contact_is_left_to_the_engine() -> None:
    engine = ScriptedEngine()
    engine.place("a", 0.0, "ground", (0.001, HALF))
    assert settled(engine, StackStability(engine)).frozen == ()


def test_a_moving_brick_is_not_frozen_until_it_is_slow() -> None:
    engine = ScriptedEngine()
    engine.place("a", 0.0, "ground", (-HALF, HALF))
    engine.bricks["a"] = BodyState(Pose((0.0, 0.0, 0.0)), velocity_W=(0.0, 0.0, -0.02))
    stability = StackStability(engine)
    assert settled(engine, stability).frozen == ()
    engine.bricks["a"] = BodyState(Pose((0.0, 0.0, 0.0)))
    assert settled(engine, stability).frozen == ("a",)


def test_a_brick_at_the_top_of_its_flight_is_not_frozen_in_the_air() -> None:
    #   It is slow there for 2 speed / g = 1 ms, less than it must be slow to be tested.
    engine = ScriptedEngine()
    stability = StackStability(engine)
    engine.place("a", 0.0, "ground", (-HALF, HALF), gap=0.0004)
    for speed in (0.01, 0.004, -0.004, -0.01):
        engine.bricks["a"] = BodyState(Pose((0.0, 0.0, 0.0)), velocity_W=(0.0, 0.0, speed))
        engine.clock += 0.008 / 9.81
        assert stability.update().frozen == ()


def test_the_brick_that_overloads_a_stack_wakes_the_failing_brick_and_all_above_it() -> None:
    #         |--c--|      com of b and c together lies beyond the end of a
    #     |--b--|
    # |--a--|
    engine = ScriptedEngine()
    stability = StackStability(engine)
    for name, x, on, overlap in (
        ("a", 0.0, "ground", (-HALF, HALF)),
        ("b", 0.04, "a", (-0.01, HALF)),
        ("c", 0.08, "b", (0.03, 0.09)),
    ):
        engine.place(name, x, on, overlap)
        last = settled(engine, stability)
    assert last.failed == ("b",)
    assert last.woken == ("b", "c")
    assert engine.frozen == {"a"}
    assert stability.loads["a"].mass == 1.0


def test_a_woken_brick_is_not_frozen_again_before_it_has_been_slow_for_the_hold_off() -> None:
    engine = ScriptedEngine()
    stability = StackStability(engine)
    engine.place("a", 0.0, "ground", (-HALF, HALF))
    settled(engine, stability)
    assert stability.wake(["a"]) == ("a",)
    passes = 0
    while not after_a_step(engine, stability).frozen:
        passes += 1
    assert passes * STEP == pytest.approx(stability.rest.hold_off, abs=STEP)


def column(engine: ScriptedEngine, stability: StackStability) -> None:
    for name, on in (("a", "ground"), ("b", "a"), ("c", "b")):
        engine.place(name, 0.0, on, (-HALF, HALF))
        settled(engine, stability)
    assert stability.awake() == []


def test_removing_a_brick_from_the_engine_wakes_bricks_on_it() -> None:
    engine = ScriptedEngine()
    stability = StackStability(engine)
    column(engine, stability)
    del engine.bricks["a"]
    assert after_a_step(engine, stability).woken == ("b", "c")


def test_announcing_a_removed_brick_wakes_bricks_on_it_immediately() -> None:
    engine = ScriptedEngine()
    stability = StackStability(engine, guard=False)
    column(engine, stability)
    del engine.bricks["b"]
    update = stability.taken_out(["b"])
    assert (update.woken, update.reason) == (("c",), "support removed")
    assert stability.awake() == ["c"]
    assert stability.is_frozen("a")


def test_removing_the_table_wakes_bricks_on_it() -> None:
    engine = ScriptedEngine()
    stability = StackStability(engine)
    column(engine, stability)
    engine.immovable.remove("ground")
    assert after_a_step(engine, stability).woken == ("a", "b", "c")


@pytest.mark.parametrize(
    ("moved", "woken"), [("ground", ("a", "b", "c")), ("a", ("a", "b", "c")), ("b", ("b", "c")), ("c", ("c",))]
)
def test_externally_moved_or_pushed_bricks_wake_with_all_on_them(moved: BodyId, woken: tuple[BodyId, ...]) -> None:
    engine = ScriptedEngine()
    stability = StackStability(engine)
    column(engine, stability)
    engine.bricks[moved] = BodyState(Pose((0.0, 0.0, 0.0)), velocity_W=(0.1, 0.0, 0.0))
    if moved == "ground":
        engine.unlisted.add("ground")
    assert after_a_step(engine, stability).woken == woken


def test_nothing_is_taken_to_rest_on_a_body_that_is_neither_brick_nor_fixed() -> None:
    engine = ScriptedEngine()
    engine.place("a", 0.0, "robot", (-HALF, HALF))
    assert settled(engine, StackStability(engine)).frozen == ()


def test_bricks_set_down_at_rest_are_tested_before_any_step() -> None:
    engine = ScriptedEngine()
    stability = StackStability(engine)
    engine.place("a", 0.0, "ground", (-HALF, HALF))
    stability.set_down(["a"])
    assert stability.update().frozen == ("a",)


def test_removing_a_counterweight_wakes_bricks_that_it_held() -> None:
    #   |w|    |x|      w is set first; without it, com of beam and x lies 15 mm out, and the post ends at 10 mm
    #    |--beam--|
    #      |post|
    engine = ScriptedEngine()
    stability = StackStability(engine)
    for name, x, on, overlap in (
        ("post", 0.0, "ground", (-0.01, 0.01)),
        ("beam", 0.0, "post", (-0.01, 0.01)),
        ("w", -0.015, "beam", (-0.02, -0.01)),
        ("x", 0.03, "beam", (0.02, 0.04)),
    ):
        engine.place(name, x, on, overlap)
        settled(engine, stability)
    assert stability.awake() == []
    del engine.bricks["w"]
    update = after_a_step(engine, stability)
    assert update.failed == ("beam",)
    assert update.woken == ("beam", "x")
