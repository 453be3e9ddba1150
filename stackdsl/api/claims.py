"""Claims, for what is expected and for what is known.

Written by `make words` from the models of the language; docs/language.md says more of every key. What is left out, or
None, is not written, and has its default there. Quantities are texts with their units, as in YAML: "12 mm".
"""

from collections.abc import Sequence

from stackdsl.api.written import Written, written


def stands(
    what: str | None = None,
    /,
    *,
    levels: int | None = None,
    bricks: Sequence[str] | None = None,
    for_: str | None = None,
    share: str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """Bricks are where they came to rest.

    what: `all`
    levels: at least so many levels, from the lowest
    bricks: these bricks
    for_: this long after the last action
    share: in this share of the samples, all of it
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"levels": levels, "bricks": bricks, "for": for_, "share": share}
    return written(
        {
            "stands": what if what is not None else what_is_written,
            "system": system,
            "source": source,
            "because": because,
        }
    )


def collapses(
    what: str | None = None,
    /,
    *,
    at: str | None = None,
    brick: str | None = None,
    time: str | None = None,
    share: str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """The structure collapses.

    what: `any`
    at: the level under construction when it does
    brick: the first brick that does
    time: when it does
    share: in this share of the samples
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"at": at, "brick": brick, "time": time, "share": share}
    return written(
        {
            "collapses": what if what is not None else what_is_written,
            "system": system,
            "source": source,
            "because": because,
        }
    )


def leaves(
    *,
    levels: int | str | None = None,
    bricks: int | str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """How much of the structure stands at the end.

    levels: levels, from the lowest, all of whose bricks stand
    bricks: bricks, whichever they are
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"levels": levels, "bricks": bricks}
    return written({"leaves": what_is_written, "system": system, "source": source, "because": because})


def falls(
    *,
    bricks: Sequence[str] | None = None,
    count: int | str | None = None,
    for_: str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """Which bricks fall, or how many.

    bricks: these bricks, and no other
    count: how many bricks, whichever they are
    for_: this long after the last action; default: as long as it is watched
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"bricks": bricks, "count": count, "for": for_}
    return written({"falls": what_is_written, "system": system, "source": source, "because": because})


def pivots(
    *,
    about: str | None = None,
    within: int | str | None = None,
    proportions: float | str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """How what falls begins to.

    about: what stands still and is turned about; or ground
    within: between where bricks go and where the proof says, at most
    proportions: between how far bricks go and the proof says, both as shares of the furthest, at most
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"about": about, "within": within, "proportions": proportions}
    return written({"pivots": what_is_written, "system": system, "source": source, "because": because})


def lands(
    *,
    reach: str | None = None,
    bearing: int | str | None = None,
    within: int | str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """Where what fell comes down.

    reach: how far
    bearing: which way: 0 deg = +x, 90 deg = +y
    within: how far from the bearing, at most
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"reach": reach, "bearing": bearing, "within": within}
    return written({"lands": what_is_written, "system": system, "source": source, "because": because})


def displaced(
    *,
    bricks: int | str | None = None,
    by: str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """How many bricks have moved.

    bricks: how many
    by: how far a brick has at least moved to be counted
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"bricks": bricks, "by": by}
    return written({"displaced": what_is_written, "system": system, "source": source, "because": because})


def drift(
    what: str | None = None,
    /,
    *,
    is_: str | None = None,
    bricks: Sequence[str] | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """The largest shift of a brick after it came to rest.

    what: the shift
    is_: the shift
    bricks: of these bricks; default: of all
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"is": is_, "bricks": bricks}
    return written(
        {"drift": what if what is not None else what_is_written, "system": system, "source": source, "because": because}
    )


def rests_on(
    *,
    brick: str | None = None,
    support: str | None = None,
    share: str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """One brick is carried by another.

    brick: the upper brick
    support: the lower one, or ground
    share: part of its load that goes there
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"brick": brick, "support": support, "share": share}
    return written({"rests_on": what_is_written, "system": system, "source": source, "because": because})


def height(
    what: str | None = None,
    /,
    *,
    is_: str | None = None,
    of: str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """How high the structure reaches.

    what: the height
    is_: the height
    of: the brick whose top is measured; default: the highest
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"is": is_, "of": of}
    return written(
        {
            "height": what if what is not None else what_is_written,
            "system": system,
            "source": source,
            "because": because,
        }
    )


def untouched(
    *,
    bricks: Sequence[str] | None = None,
    levels: int | None = None,
    except_: Sequence[str] | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """Bricks are exactly where they came to rest.

    bricks: these bricks
    levels: so many levels, from the lowest
    except_: all but these bricks
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"bricks": bricks, "levels": levels, "except": except_}
    return written({"untouched": what_is_written, "system": system, "source": source, "because": because})


def energy(
    *,
    gain: str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """What happens to the energy of all bricks together.

    gain: how much that of bricks that move rises, as a share of it, heights as distances from the ground
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"gain": gain}
    return written({"energy": what_is_written, "system": system, "source": source, "because": because})


def verdict(
    what: str,
    /,
    *,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """What statics says of the structure after its last change.

    what: `stable` or `stable, counting on no gap` or `guaranteed` or `possible` or `unstable` or `undecided`
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    return written({"verdict": what, "system": system, "source": source, "because": because})


def margin(
    *,
    acceleration: str | None = None,
    tilt: str | None = None,
    friction: str | None = None,
    placement: str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """How much the proof that it stands would survive.

    acceleration: sideways in the worst direction, a plain number: times the gravity
    tilt: of the whole scene, in the worst direction
    friction: the least coefficient with which it stands
    placement: the error in the place of every brick
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"acceleration": acceleration, "tilt": tilt, "friction": friction, "placement": placement}
    return written({"margin": what_is_written, "system": system, "source": source, "because": because})


def sway(
    *,
    amplitude: str | None = None,
    frequency: str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """How far, and how fast, a brick goes to and fro after it came to rest.

    amplitude: how far to either side
    frequency: how many times a second, there and back
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"amplitude": amplitude, "frequency": frequency}
    return written({"sway": what_is_written, "system": system, "source": source, "because": because})


def penetration(
    what: str | None = None,
    /,
    *,
    is_: str | None = None,
    system: str | Sequence[str] | None = None,
    source: str | None = None,
    because: str | None = None,
) -> Written:
    """How deep two bodies get into each other, at most.

    what: the depth
    is_: the depth
    system: the system, or systems, that this is expected of; default: all
    source: of what is known from outside: where from
    because: why it is so
    """
    what_is_written = {"is": is_}
    return written(
        {
            "penetration": what if what is not None else what_is_written,
            "system": system,
            "source": source,
            "because": because,
        }
    )
