"""Timelines played on PyBullet: what stands, what falls, when, and at what cost."""

from dataclasses import replace

import pytest

from stability.problem import Stability
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.trace import STAND, BrickState, Collapse, Event, EventKind, RunVerdict, Trace
from tests.scenes import timeline_of

LENGTH = 0.1176  # of a KAPLA plank [m]


def played(build: str, rest: str = "", system: str = "thesis") -> Trace:
    return play(timeline_of(build, rest), SYSTEMS[system])


def until_it_falls(build: str, rest: str = "", system: str = "thesis") -> Trace:
    """What becomes of it is not played."""
    return play(replace(timeline_of(build, rest), aftermath=False), SYSTEMS[system])


def collapse(build: str, rest: str = "") -> Collapse:
    trace = until_it_falls(build, rest)
    assert trace.collapse is not None
    return trace.collapse


@pytest.mark.parametrize(("step", "too_many"), [(10.0, 12), (12.0, 10), (13.5, 9), (18.0, 7)])
def test_a_stepped_column_falls_with_the_first_plank_beyond_length_over_step(step: float, too_many: int) -> None:
    assert too_many == int(1000.0 * LENGTH / step) + 1
    fell = collapse(f"- column: {{levels: 14, step: {step} mm}}\n  every: 1 s")
    assert (fell.level, fell.gave_way) == (too_many, "L2.1")


def test_a_four_stack_of_25_levels_stands_without_creeping() -> None:
    trace = played("- four_stack: {levels: 25}\n  every: 1 s", "expect: [{stands: {for: 5 s}}]")
    assert trace.collapse is None
    assert trace.drift == 0.0
    assert trace.cost.steps == 0
    assert all(track.state is BrickState.FROZEN for track in trace.tracks.values())


def test_time_in_which_nothing_can_move_is_skipped() -> None:
    trace = played("- column: {levels: 2}\n  every: 1000 s", "expect: [{stands: {for: 1000 s}}]")
    assert trace.cost.simulated_time == pytest.approx(2000.0)
    assert trace.cost.steps < 100


def test_before_the_first_brick_no_system_steps() -> None:
    trace = played("- column: {levels: 1}\n  at: 1000 s", "expect: [{stands: {for: 0.1 s}}]", system="stock")
    assert trace.cost.steps == pytest.approx(0.1 * 240, abs=1)


def test_a_collapse_ends_the_build() -> None:
    trace = played("- column: {levels: 14, step: 30 mm}\n  every: 1 s")
    assert trace.collapse is not None
    states = [track.state for track in trace.tracks.values()]
    assert states[trace.collapse.level :] == [BrickState.UNPLACED] * (14 - trace.collapse.level)
    assert states[0] is BrickState.FROZEN
    assert BrickState.FALLEN in states


def test_a_dropped_plank_is_frozen_where_it_lands() -> None:
    trace = played("- bricks: [{name: plank, at: [0 mm, 0 mm, 30 mm], drop: true}]")
    track = trace.tracks["plank"]
    assert track.state is BrickState.FROZEN
    assert track.rest.position_W[2] == pytest.approx(0.0039, abs=1e-4)
    assert track.shift < 1e-4
    assert trace.edges[0].lower == "ground"


def test_a_plank_still_in_the_air_at_the_end_has_not_settled() -> None:
    trace = played("- bricks: [{name: plank, at: [0 mm, 0 mm, 50 m], drop: true}]", system="tuned")
    assert trace.verdict == "unsettled"
    # 2 s of free fall; where it is at the very end, not at the last look before.
    assert 50.0 - trace.tracks["plank"].final.position_W[2] == pytest.approx(0.5 * 9.81 * 4.0, rel=1e-3)


@pytest.mark.parametrize("height", [0.02, 0.1, 0.3, 1.0])
def test_a_dropped_plank_is_frozen_on_its_support_and_not_above_it(height: float) -> None:
    trace = played(
        f"""
        - bricks: [{{name: base, at: [0 mm, 0 mm, 3.9 mm]}}]
        - bricks: [{{name: plank, at: [0 mm, 0 mm, {11.7 + 1000.0 * height} mm], drop: true}}]
          after: built + 1 s
        """
    )
    assert trace.tracks["plank"].state is BrickState.FROZEN
    assert trace.tracks["plank"].final.position_W[2] == pytest.approx(0.0117, abs=5e-5)


@pytest.mark.parametrize("system", ["thesis", "tuned"])
def test_a_plank_dropped_from_ten_metres_does_not_pass_through_what_it_hits(system: str) -> None:
    #   It arrives at 14 m/s, 15 mm in a step of 1/960 s: twice the thickness of a plank.
    trace = played(
        """
        - bricks:
            - {name: left, at: [-40 mm, 0 mm, 3.9 mm], rotate: [0 deg, 0 deg, 90 deg]}
            - {name: right, at: [40 mm, 0 mm, 3.9 mm], rotate: [0 deg, 0 deg, 90 deg]}
        - bricks: [{name: plank, at: [0 mm, 0 mm, 10.0117 m], drop: true}]
          after: built + 1 s
        """,
        "expect: [{stands: {for: 4 s}}]",
        system,
    )
    assert trace.tracks["plank"].final.position_W[2] > 0.0038


def test_events_are_told_as_they_happen_and_kept() -> None:
    heard: list[Event] = []
    trace = play(timeline_of("- column: {levels: 2}\n  every: 1 s"), SYSTEMS["thesis"], heard.append)
    assert [event.kind for event in heard] == [EventKind.PLACED, EventKind.FROZEN] * 2
    assert [(event.kind, event.bricks) for event in trace.events] == [(event.kind, event.bricks) for event in heard]
    # Straight column: com above the middle of the contact, half a width from its border.
    assert [event.margin for event in trace.events if event.kind is EventKind.PLACED] == pytest.approx(
        [0.0117] * 2, abs=1e-4
    )


def test_a_bare_engine_says_by_its_forces_who_carries_whom() -> None:
    #   The load's centre is a quarter of the way from left to right support: lever rule 3 to 1, within the contacts.
    trace = played(
        """
        - bricks:
            - {name: left, at: [-40 mm, 0 mm, 3.9 mm], rotate: [0 deg, 0 deg, 90 deg]}
            - {name: right, at: [40 mm, 0 mm, 3.9 mm], rotate: [0 deg, 0 deg, 90 deg]}
            - {name: beam, at: [-20 mm, 0 mm, 11.7 mm]}
        """,
        system="tuned",
    )
    shares = {edge.lower: edge.share for edge in trace.edges if edge.upper == "beam"}
    assert sum(shares.values()) == pytest.approx(1.0)
    assert 31.7 / 80 <= 1.0 - shares["right"] <= 1.0
    assert shares["left"] > 0.5


# Of the others, tests/stackdsl/checking/test_bit_identity.py compares more.
@pytest.mark.parametrize("system", [name for name in SYSTEMS if name not in ("exact", "thesis", "tuned", "stock")])
def test_the_same_timeline_gives_the_same_trace_to_the_bit(system: str) -> None:
    build = "- column: {levels: 4, step: 40 mm}\n  every: 0.5 s"
    one, other = played(build, system=system), played(build, system=system)
    assert one.tracks == other.tracks
    assert one.events == other.events
    assert repr(one.edges) == repr(other.edges)  # a share that statics leave open is nan, which equals nothing


# Centres in mm and yaws in deg. At each joint, com above must lie in both faces; the eighth plank is 1 mm too far out.
WINDING = (
    (0, 0, 0), (20.30942, 0.94121, 0), (39.58275, -3.89360, 0), (24.93301, 2.71721, -45),
    (27.81992, 5.03783, -90), (37.45847, 2.99969, -135), (31.69210, 11.70890, -45), (30.35795, 17.37163, -45),
)  # fmt: skip


def test_a_winding_column_falls_although_it_starts_slowly() -> None:
    #   Woken at rest, it turns at a tenth of a radian a second after a tenth of a second: slow, but not at rest.
    bricks = "\n".join(
        f"    - {{at: [{x} mm, {y} mm, {7.8 * i + 3.9} mm], rotate: [0 deg, 0 deg, {yaw} deg]}}"
        for i, (x, y, yaw) in enumerate(WINDING)
    )
    assert collapse(f"- bricks:\n{bricks}\n  every: 1 s").level == 8


def test_a_plank_whose_centre_is_just_inside_both_faces_is_held() -> None:
    #   1.2 mm inside; PyBullet's first contact points leave a corner out and would let it tip.
    trace = played(
        """
        - bricks:
            - {at: [0 mm, 0 mm, 3.9 mm]}
            - {at: [0 mm, 0 mm, 11.7 mm]}
            - {at: [15 mm, 10.5 mm, 19.5 mm], rotate: [0 deg, 0 deg, 10 deg]}
          every: 1 s
        """
    )
    assert trace.collapse is None
    assert trace.drift == 0.0


@pytest.mark.parametrize("gravity", [0.05, 1.0, 100.0])
def test_gravity_changes_no_collapse_level(gravity: float) -> None:
    column = "- column: {levels: 12, step: 13.5 mm}\n  every: 20 s"
    assert collapse(column, f"world: {{gravity: {gravity} m/s2}}").level == 9


def test_a_brick_is_not_placed_into_one_that_has_fallen_there() -> None:
    with pytest.raises(BlockedPlacementError, match="'e' cannot be placed at 2 s: 'd' has moved into its place"):
        played(
            """
            - bricks: [{name: d, at: [0 mm, 0 mm, 60 mm], drop: true}]
            - bricks: [{name: e, at: [0 mm, 0 mm, 3.9 mm]}]
              after: built + 2 s
            """
        )


def test_turning_the_scene_about_the_vertical_changes_no_collapse_level() -> None:
    for heading in (0, 30, 90, 200):
        assert collapse(f"- column: {{levels: 12, step: 13.5 mm, heading: {heading} deg}}\n  every: 1 s").level == 9


def test_moving_the_scene_changes_no_collapse_level() -> None:
    assert collapse("- column: {levels: 12, step: 13.5 mm, origin: [3 m, -2 m, 0 m]}\n  every: 1 s").level == 9


@pytest.mark.parametrize("factor", [0.5, 10.0])
def test_scaling_bricks_and_steps_changes_no_collapse_level(factor: float) -> None:
    size = ", ".join(f"{side * factor} mm" for side in (117.6, 23.4, 7.8))
    column = f"- column: {{levels: 12, step: {13.5 * factor} mm}}\n  every: 2 s"
    assert collapse(column, f"brick: {{size: [{size}], density: 557 kg/m3}}").level == 9


# --- exact ------------------------------------------------------------------------------------------------------------


def test_exact_proves_a_four_stack_of_200_levels_without_an_engine() -> None:
    trace = played("- four_stack: {levels: 200}\n  every: 1 s", system="exact")
    assert trace.verdict == "stands"
    assert (trace.cost.steps, trace.drift) == (0, 0.0)
    assert sum(trace.cost.proofs.values()) == 400
    assert all(event.reason for event in trace.events if event.kind is EventKind.FROZEN)


@pytest.mark.parametrize(("step", "too_many"), [(10.0, 12), (12.0, 10), (13.5, 9), (18.0, 7)])
def test_exact_says_what_tips_over_what_and_the_engine_shows_it(step: float, too_many: int) -> None:
    trace = until_it_falls(f"- column: {{levels: 14, step: {step} mm}}\n  every: 1 s", system="exact")
    assert trace.collapse is not None
    assert trace.collapse.level == too_many
    assert trace.collapse.gave_way == "L2.1"  # the lowest of those that move
    assert trace.statics is not None
    assert trace.statics.stability is Stability.UNSTABLE
    woken = next(event for event in trace.events if event.kind is EventKind.WOKEN)
    assert "over L1.1" in woken.reason
    assert set(woken.bricks) == {f"L{level}.1" for level in range(2, too_many + 1)}


def test_what_still_stands_without_the_bricks_that_fall_stays_frozen() -> None:
    trace = played(
        "- column: {levels: 5, step: 30 mm}\n- column: {levels: 3, origin: [0 mm, 1 m, 0 mm]}", system="exact"
    )
    last = {name: track.state for name, track in trace.tracks.items() if track.placed.position_W[1] > 0.5}
    assert set(last.values()) == {BrickState.FROZEN}
    assert trace.tracks["L1.1"].state in STAND  # it is kicked by some tenths of a millimetre, as with all awake


def test_a_dropped_plank_is_proven_where_it_lands() -> None:
    trace = played("- bricks: [{name: plank, at: [0 mm, 0 mm, 30 mm], drop: true}]", system="exact")
    assert trace.tracks["plank"].state is BrickState.FROZEN
    assert trace.statics is None  # nothing was set down
    assert trace.edges[0].lower == "ground"


def test_a_plank_on_a_slope_beyond_the_angle_of_friction_slides_under_exact() -> None:
    #   tan 27 deg = 0.51 > 0.5 > tan 26 deg
    for angle, verdict in ((26, "stands"), (27, "collapses")):
        trace = played("- column: {levels: 1}", f"world: {{tilt: {angle} deg}}", system="exact")
        assert trace.verdict == verdict


def test_bricks_set_down_together_are_proven_together_whatever_their_order() -> None:
    #   The counterweight is listed last, and the beam would tip without it.
    trace = played(
        """
        - bricks:
            - {name: post, at: [0 mm, 0 mm, 3.9 mm], rotate: [0 deg, 0 deg, 90 deg]}
            - {name: beam, at: [20 mm, 0 mm, 11.7 mm]}
            - {name: weight, at: [-25 mm, 0 mm, 19.5 mm], rotate: [0 deg, 0 deg, 90 deg]}
        """,
        system="exact",
    )
    assert trace.cost.steps == 0
    assert trace.verdict == "stands"


def test_where_only_a_proof_is_asked_for_no_engine_shows_what_falls() -> None:
    overhang = "- column: {levels: 2, step: 60 mm}"
    judged = played(overhang, "expect: [{verdict: unstable}]", system="exact")
    assert judged.verdict is RunVerdict.UNWATCHED
    assert {name: track.state for name, track in judged.tracks.items()} == {
        "L1.1": BrickState.FROZEN,
        "L2.1": BrickState.UNWATCHED,
    }
    assert judged.cost.steps == 0
    watched = played(overhang, "expect: [{verdict: unstable}, {collapses: any}]", system="exact")
    assert watched.cost.steps > 0


def test_what_moved_before_a_fall_is_told_apart_from_the_fall() -> None:
    # Two bricks stand; the third hangs over by half its length and more, and falls.
    falling = timeline_of(
        "- column: {levels: 2}\n  every: 1 s\n- bricks:\n    - {at: [70 mm, 0 mm, 19.5 mm], level: 3}"
    )
    exact, bare = play(falling, SYSTEMS["exact"]), play(falling, SYSTEMS["stock"])
    assert exact.shift_before == 0.0
    assert 0.0 < bare.shift_before < 0.001 < max(track.shift for track in bare.tracks.values())
