"""What an impact comes to in the scene: the place where each kind registers how."""

from functools import singledispatch

from stackdsl.compiling.impacts.scene import Scene
from stackdsl.language.impacts.impact_kind import ImpactKind
from stackdsl.timeline import Action


@singledispatch
def actions_of(done: ImpactKind, _scene: Scene) -> tuple[Action, ...]:
    """The actions of the timeline that an impact comes to. Raises MissError if it cannot be as it is written."""
    if done.slid_in is not None:
        return ()  # it is placed with all other bricks of the structure
    raise NotImplementedError(f"nothing says what {type(done).__name__} comes to")
