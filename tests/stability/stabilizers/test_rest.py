"""Freeze and wake as one transition."""

import pytest

from stability.model import BodyState, Pose
from stability.stabilizers.rest import Activity, Evidence, RestLimits, next_activity

LIMITS = RestLimits()
STILL = Pose((0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("now", "seen", "then"),
    [
        (Activity.FREE, Evidence(stands=True), Activity.FROZEN),
        (Activity.FREE, Evidence(slow_for=10.0), Activity.FREE),
        (Activity.FROZEN, Evidence(), Activity.FROZEN),
        (Activity.FROZEN, Evidence(fails=True), Activity.UNSTABLE),
        (Activity.UNSTABLE, Evidence(stands=True), Activity.UNSTABLE),
        (Activity.UNSTABLE, Evidence(slow_for=LIMITS.hold_off), Activity.FREE),
    ],
)
def test_each_state_is_left_for_its_one_reason(now: Activity, seen: Evidence, then: Activity) -> None:
    assert next_activity(now, seen, LIMITS) is then


@pytest.mark.parametrize(
    ("state", "slow"),
    [
        (BodyState(STILL), True),
        (BodyState(STILL, velocity_W=(0.0, 0.0, -2.0 * LIMITS.speed)), False),
        (BodyState(STILL, angular_velocity_W=(2.0 * LIMITS.angular_speed, 0.0, 0.0)), False),
    ],
)
def test_a_brick_that_moves_or_turns_is_not_at_rest(state: BodyState, slow: bool) -> None:
    assert LIMITS.slow(state) is slow
