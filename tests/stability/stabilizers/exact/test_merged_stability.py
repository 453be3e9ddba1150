"""Merging of two stabilizers whose bricks come near to each other."""

from stability.model import BodyState, Pose
from stability.problem import Stability
from stability.stabilizers.exact.stabilizer import ProvenStability
from stability.stabilizers.protocol import BrickObserver
from tests.stability.stabilizers.exact.test_proven_stability import GROUND_PLANE, PLANK, STEP, BoxEngine

HEIGHT = PLANK[2]


def watched(places: dict[str, tuple[float, float]]) -> tuple[BoxEngine, ProvenStability]:
    """Level planks at these places along x and of these heights, set down and judged."""
    engine = BoxEngine()
    engine.bricks |= {name: BodyState(Pose((x, 0.0, z))) for name, (x, z) in places.items()}
    extension = ProvenStability(engine, (GROUND_PLANE,), guard=False)
    extension.set_down(places)
    extension.update()
    return engine, extension


def come_near(one: BoxEngine, other: BoxEngine) -> None:
    one.bricks |= other.bricks
    one.frozen |= other.frozen


def test_merged_frozen_bricks_keep_a_proof_and_falling_ones_stay_awake() -> None:
    near, here = watched({"a": (0.0, 0.5 * HEIGHT)})
    far, there = watched({"b": (1.0, 0.5 * HEIGHT), "c": (1.07, 1.5 * HEIGHT)})  # more than half of it hangs over
    assert there.awake() == ["c"]
    come_near(near, far)
    here.absorb(there)
    assert here.is_frozen("a")
    assert here.is_frozen("b")
    assert here.awake() == ["c"]
    assert here.assembly.verdict().stability is Stability.STABLE
    assert here.shares()["b"] == {"ground": 1.0}
    assert near.frozen == {"a", "b"}


def test_merged_refusals_delay_the_next_judgement() -> None:
    near, here = watched({"a": (0.0, 0.5 * HEIGHT)})
    far, there = watched({"b": (1.0, 0.5 * HEIGHT), "c": (1.07, 1.5 * HEIGHT)})
    come_near(near, far)
    here.absorb(there)
    near.bricks["c"] = BodyState(Pose((1.02, 0.0, 1.5 * HEIGHT)))  # where it stands
    frozen_at = None
    for step in range(1, 40):
        near.clock = step * STEP
        if here.update().frozen:
            frozen_at = near.clock
            break
    assert frozen_at is not None
    assert 0.1 <= frozen_at < 0.25  # the hold-off, and once more


def test_all_that_is_known_of_a_brick_goes_over() -> None:
    #   Caches of values from shapes and proofs are not merged.
    homes = {kind: kind.__module__.split(".") for kind in BrickObserver.__subclasses__()}
    kinds = [
        kind for kind, home in homes.items() if home[:2] == ["stability", "stabilizers"] and "published" not in home
    ]
    assert len(kinds) > 8
    assert {each.__name__ for each in kinds if each.absorb is BrickObserver.absorb} == {"LimitsBySize", "HoldingForces"}
