"""What to say of frictions that an engine could not have."""

from collections.abc import Iterable, Iterator

from stability.engines.friction_told import WrongFriction
from stackdsl.outcome import VariantResult


def wrong_friction_text(wrong: WrongFriction) -> str:
    """Between whom, how far off, when, and what that leaves in doubt."""
    pair = f"{wrong.one} and {wrong.other} had {wrong.had:.3g} in place of {wrong.asked:.3g} at {wrong.time:.1f} s"
    reason = "an engine with one factor a body has none that does for all that touched"
    return f"{reason}: {pair}; what is proven stays so"


def wrong_frictions(results: Iterable[VariantResult]) -> Iterator[str]:
    """A line for each run that had one."""
    for result in results:
        if result.wrong_friction is not None:
            yield f"{result.name}: {wrong_friction_text(result.wrong_friction)}"
