"""A system plays the published method with its own readings of the text."""

from dataclasses import replace

import pytest

from stability.stabilizers.published.support import AS_READ, ActsAt, Readings
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import SYSTEMS
from stackdsl.trace import EventKind
from tests.scenes import timeline_of


@pytest.mark.parametrize(("readings", "wakes"), [(AS_READ, False), (Readings(acts_at=ActsAt.COM_ABOVE), True)])
def test_to_the_letter_the_second_level_of_a_four_stack_wakes_what_it_lies_on(readings: Readings, wakes: bool) -> None:
    """Worked by hand in tests/stability/stabilizers/published/test_readings.py."""
    system = replace(SYSTEMS["thesis"], readings=readings)
    two = timeline_of("- four_stack: {levels: 2}\n  every: 1 s", "brick: kapla\nexpect: [stands: all]\n")
    woken = {name for event in play(two, system).events if event.kind is EventKind.WOKEN for name in event.bricks}
    assert bool(woken & {"L1.1", "L1.2"}) is wakes
