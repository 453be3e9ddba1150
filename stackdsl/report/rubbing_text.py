"""What to say of bricks that rub otherwise than most."""

from collections.abc import Iterator
from itertools import product

from stability.friction_law import Friction, law_of
from stability.statics.facts import Placed
from stability.statics.structure import Structure
from stackdsl.timeline import Timeline


def rubbing_lines(timeline: Timeline) -> Iterator[str]:
    """What has a friction of its own, and pairs; and of which pairs no two bodies touch as they are set down."""
    law = law_of(timeline.world.friction)
    if not law.differs:
        return
    if law.own:
        own = ", ".join(f"{name} {each:g}" for name, each in sorted(law.own.items()))
        yield f"  friction of their own: {own}; of two that touch: {law.rule}"
    touching = _touching(timeline, law)
    for pair, each in sorted(law.between.items()):
        never = "" if frozenset(pair) in touching else "; no two of these touch as they are set down"
        yield f"  friction {each:g} between {pair[0]} and {pair[1]}{never}"


def _touching(timeline: Timeline, law: Friction) -> set[frozenset[str]]:
    """Which bodies and kinds touch each other at any time while nothing moves."""
    world = timeline.world
    structure = Structure(world.planes, (), 0.0, world.gravity, world.tolerances)
    for placement in timeline.placements:
        structure.put(Placed(placement.brick, placement.pose))
    return {
        frozenset(names)
        for contact in structure.contacts_of(list(structure.bricks))
        for names in product(
            (contact.lower, law.kinds.get(contact.lower, contact.lower)),
            (contact.upper, law.kinds.get(contact.upper, contact.upper)),
        )
    }
