"""Claims about falls after a hit count the bricks that a small disturbance may bring down."""

from dataclasses import replace

from stackdsl.goldens.snapshot import UNCLEAR, unclear_falls
from stackdsl.trace import BrickState, Collapse
from tests.stackdsl.goldens.towers import states, taken
from tests.stackdsl.judging.test_judge import STANDING, track
from tests.stackdsl.viewing.views import views_of

STRUCK = """
    scenario: struck
    brick_types:
      block: {size: [200 mm, 100 mm, 60 mm], mass: 2.4 kg}
      box: {size: [150 mm, 150 mm, 150 mm], mass: 6 kg}
    brick: block
    friction: 0.6
    build:
      - wall: {levels: 5, bricks: 2}
    impacts:
      - after: built + 1 s
        throw: {brick: box, name: box, at: L4.2, from: {bearing: 90 deg, distance: 1 m}, speed: 6 m/s}
    systems: [exact]
    expect: [{falls: {count: 0 .. 10}}, {collapses: any}]
"""


def test_a_number_of_fallen_bricks_rests_on_the_bricks_that_are_near_a_fall() -> None:
    (run,) = views_of(STRUCK)
    unclear = unclear_falls(run.trace, modelled=True)
    falls, collapses = run.result.outcomes
    assert unclear
    assert falls.unclear == len(unclear)
    assert collapses.unclear == 0  # that any brick falls, whichever it is


def test_a_brick_that_only_slid_is_unclear_only_between_standing_and_displaced() -> None:
    limit = 0.5 * 0.0078
    slid = replace(track("slid", 1), shift=limit, sunk=0.0)
    sank = replace(track("sank", 1), shift=limit, sunk=0.5 * limit)
    fell = track("fell", 1, shift=2.0 * limit, state=BrickState.FALLEN)
    tracks = {each.brick.id: each for each in (slid, sank, fell)}
    trace = replace(STANDING, tracks=tracks, collapse=Collapse(2.5, level=1, brick="fell"))
    assert unclear_falls(trace, modelled=True) == {"sank", "fell"}
    snapshot = taken(trace)
    assert states(snapshot) == dict.fromkeys(tracks, UNCLEAR)
    assert snapshot.slid == {"slid"}
