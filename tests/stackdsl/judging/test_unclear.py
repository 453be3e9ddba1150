"""Claims about falls after a hit count the bricks whose states a golden file does not lock."""

from stackdsl.goldens.snapshot import unclear_bricks
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


def test_a_number_of_fallen_bricks_rests_on_the_bricks_whose_states_no_golden_file_locks() -> None:
    (run,) = views_of(STRUCK)
    unclear = unclear_bricks(run.trace, modelled=True)
    falls, collapses = run.result.outcomes
    assert unclear
    assert falls.unclear == len(unclear)
    assert collapses.unclear == 0  # that any brick falls, whichever it is
