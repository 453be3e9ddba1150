"""Loads together with shaking ground and pushes: bricks at rest are judged with the loads on them."""

import pytest

from stackdsl import Scenario, claims, layouts, margins
from stackdsl.simulation.known_systems import system_named
from stackdsl.simulation.runner import play
from stackdsl.trace import EventKind, Trace
from tests.scenes import timeline_of

G, MU = 9.81, 0.5
BLOCK = "- bricks: [{name: block, brick: {size: [0.5 m, 0.5 m, 0.2 m], mass: 10 kg}, at: [0 m, 0 m, 0.1 m]}]"


def played(build: str, rest: str) -> Trace:
    return play(timeline_of(build, f"\nfriction: {MU}\n{rest}\nexpect: [stands: all]"), system_named("exact"))


@pytest.mark.parametrize(("share", "moves"), [(0.999, False), (1.001, True)])
@pytest.mark.parametrize(
    ("load", "limit"),
    [
        # the ground pulls the block back by m a, together with the push or against it
        ("force: 20 N, towards: 180 deg", MU * G - 2.0),
        ("force: 20 N, towards: 0 deg", MU * G + 2.0),
        # a weight without inertia presses the block on
        ("weight: 49.05 N", 1.5 * MU * G),
    ],
)
def test_shaking_moves_a_loaded_block_beyond_what_friction_leaves(
    load: str, limit: float, share: float, moves: bool
) -> None:
    table = f"[[0 s, {share * limit} m/s2], [0.2 s, {share * limit} m/s2]]"
    shake = f"world: {{shake: {{bearing: 0 deg, at: 2 s, table: {table}}}}}"
    trace = played(BLOCK, f"{shake}\nloads: [{{{load}, brick: block, at: 1 s}}]")
    assert any(event.kind is EventKind.WOKEN for event in trace.events) is moves


@pytest.mark.parametrize("load", [0.0, 0.5, 2.0])
def test_a_plank_in_a_loaded_column_slides_against_the_load_above(load: float) -> None:
    """The plank stops after v^2 / (2 mu g (7 + 2 F / m g)), as the frozen plank above presses with its load, too."""
    mass, speed = 0.012, 1.0
    brick = "brick: {size: [117.6 mm, 23.4 mm, 7.8 mm], mass: 12 g}"
    push = f"impacts: [{{after: built + 2 s, push: {{brick: L3.1, impulse: [{mass * speed} N*s, 0 N*s, 0 N*s]}}}}]"
    loads = f"loads: [{{weight: {load * mass * G} N, brick: L6.1}}]"
    trace = played("- column: {levels: 6}", f"{brick}\n{push}\n{loads}")
    track = trace.tracks["L3.1"]
    way = track.final.position_W[0] - track.placed.position_W[0]
    # friction begins within the first steps of the engine
    assert way == pytest.approx(speed**2 / (2 * MU * G * (7 + 2 * load)), abs=0.0016 * speed)
    assert all(each.frozen for each in trace.tracks.values())


def test_loads_of_a_scenario_in_python_are_those_of_yaml() -> None:
    scenario = Scenario(
        "loaded",
        brick={"size": ["0.5 m", "0.5 m", "0.2 m"], "mass": "10 kg"},
        build=[layouts.column(levels=1)],
        loads=[{"force": "30 N", "towards": "0 deg", "brick": "L1.1"}],
        expect=[claims.verdict("stable")],
    )
    assert margins(scenario).load_factor == pytest.approx(MU * 10 * G / 30, rel=1e-6)
    assert scenario.play().passed
