"""The published method on engines that it was not tried on: what stands, what falls, and how."""

import pytest

from stability.engines.protocol import EngineSettings
from stackdsl.simulation.known_systems import missing, system_named
from stackdsl.simulation.runner import play
from stackdsl.trace import BrickState, EventKind, Trace
from tests.engines_at_hand import THESIS_PEERS
from tests.scenes import timeline_of

ON_PEERS = pytest.mark.parametrize(
    "peer",
    [
        pytest.param(
            name, marks=pytest.mark.skipif(bool(missing([name])), reason=f"{name} needs what is not installed")
        )
        for name in THESIS_PEERS
    ],
)


def played(peer: str, build: str, rest: str = "expect: [collapses: any]\n") -> Trace:
    return play(timeline_of(build, f"brick: kapla\nfriction: 0.5\n{rest}"), system_named(peer))


def test_a_peer_with_the_method_has_the_engine_of_the_one_without() -> None:
    def engine(name: str) -> EngineSettings:
        return system_named(name).engine

    assert engine("mujoco-thesis") == engine("mujoco")


@ON_PEERS
def test_a_four_stack_is_frozen_plank_by_plank(peer: str) -> None:
    trace = played(peer, "- four_stack: {levels: 6}\n  every: 1 s", "expect: [stands: all]\n")
    assert {track.state for track in trace.tracks.values()} == {BrickState.FROZEN}
    assert sum(len(event.bricks) for event in trace.events if event.kind is EventKind.FROZEN) == 12
    assert trace.drift < 1e-7  # [m] an engine may be of single precision


@ON_PEERS
def test_a_column_of_single_planks_falls_where_its_centre_of_mass_passes_the_edge(peer: str) -> None:
    #   L = 117.6 mm, d = 18 mm: six stand, the seventh is too many (Eq. 1 and 2 are exact for single branches).
    trace = played(peer, "- column: {levels: 9, step: 18 mm}\n  every: 1 s")
    assert trace.collapse is not None
    assert trace.collapse.level == 7


@ON_PEERS
def test_two_planks_that_lean_on_each_other_are_frozen(peer: str) -> None:
    trace = played(peer, "- card_house: {levels: 1, angle: 70 deg}", "expect: [stands: all]\n")
    assert {track.state for track in trace.tracks.values()} == {BrickState.FROZEN}


@ON_PEERS
def test_a_slant_tower_turns_about_its_lowest_level_and_does_not_fall_straight_down(peer: str) -> None:
    """Its centre is 16.0 to 16.3 mm farther out when the ground takes it, by runs without any method."""
    slant = "- four_stack: {levels: 14, step: 12.8 mm, spacing: 90 mm}\n  every: 1 s"
    trace = played(peer, slant, "expect: [lands: {reach: 13.7 mm .. 18.5 mm}]\n")
    assert trace.collapse is not None
    assert trace.collapse.level == 9
    assert trace.landing is not None
    assert trace.landing.reach == pytest.approx(0.0161, abs=0.0005)
