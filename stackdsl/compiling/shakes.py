"""How and when the ground shakes, as an action of the timeline."""

from collections.abc import Iterator
from math import cos, sin

from stability.mechanics.ground_motion import GroundMotion
from stackdsl.compiling.built import Built
from stackdsl.compiling.moment import Moment
from stackdsl.language.schema import Scenario
from stackdsl.timeline import Shake


def shakes(built: Built, scenario: Scenario) -> Iterator[tuple[Moment, Shake]]:
    """What the ground does, if it moves at all: level, also where the scene is tilted."""
    shake, moment = scenario.world.shake, built.shaken
    if shake is not None and moment is not None:
        # Rounded to where processors agree on them.
        direction_W = (round(cos(shake.bearing), 15), round(sin(shake.bearing), 15), 0.0)
        yield moment, Shake(moment.time, GroundMotion(shake.course, direction_W, moment.time))
