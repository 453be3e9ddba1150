"""Impacts.

Written by `make words` from the models of the language; docs/language.md says more of every key. What is left out, or
None, is not written, and has its default there. Quantities are texts with their units, as in YAML: "12 mm".
"""

from collections.abc import Mapping, Sequence

from stackdsl.api.written import Written, written


def remove(
    *,
    brick: str | None = None,
    bricks: Sequence[str] | None = None,
    when: int | str | None = None,
    after: str | None = None,
    every: str | None = None,
) -> Written:
    """Pull bricks out.

    brick: the brick
    bricks: the bricks
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    every: from one repetition to the next; default: all at one time
    """
    what_is_written = {"brick": brick, "bricks": bricks}
    return written({"remove": what_is_written, "at": when, "after": after, "every": every})


def insert(
    *,
    name: str | None = None,
    at: Sequence[int | str] | None = None,
    on: str | Sequence[str] | None = None,
    beside: str | None = None,
    towards: int | str | None = None,
    offset: Sequence[int | str] | None = None,
    rotate: Sequence[int | str] | None = None,
    brick: str | object | None = None,
    level: int | None = None,
    friction: float | None = None,
    when: int | str | None = None,
    after: str | None = None,
    every: str | None = None,
) -> Written:
    """Slide a brick in.

    name: its name; default: by place, such as L3.2
    at: [x, y, z] of its middle, or of the origin of a solid
    on: the brick, or bricks, on whose top it lies, in the middle of their centres; or the ground
    beside: the brick that it stands beside, touching it, as low as that
    towards: where it stands, seen from what it is beside: 0 deg = +x, 90 deg = +y
    offset: shifts it from there by [x, y, z], in the axes of the scene
    rotate: turn about x, then y, then z, the axes of the scene
    brick: default: the brick of the step, or else of the scenario
    level: its level; default: judged by its height
    friction: Coulomb coefficient of its own; default: of what it is
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    every: from one repetition to the next; default: all at one time
    """
    what_is_written = {
        "name": name,
        "at": at,
        "on": on,
        "beside": beside,
        "towards": towards,
        "offset": offset,
        "rotate": rotate,
        "brick": brick,
        "level": level,
        "friction": friction,
    }
    return written({"insert": what_is_written, "at": when, "after": after, "every": every})


def throw(
    *,
    name: str | None = None,
    brick: str | object | None = None,
    at: str | None = None,
    from_: Mapping[str, object] | None = None,
    speed: str | None = None,
    turn: int | str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    every: str | None = None,
) -> Written:
    """Throw a brick at it.

    name: its name; default: thrown-1 if it is the first impact
    brick: what is thrown; default: the scenario's brick
    at: the aim: the middle of a level, or of a brick
    from_: where it comes from
    speed: how fast it comes along the ground
    turn: about its upright axis, from end-on; at 90 deg it comes broadside
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    every: from one repetition to the next; default: all at one time
    """
    what_is_written = {"name": name, "brick": brick, "at": at, "from": from_, "speed": speed, "turn": turn}
    return written({"throw": what_is_written, "at": when, "after": after, "every": every})


def push(
    *,
    brick: str | None = None,
    impulse: Sequence[int | str] | None = None,
    point: Sequence[int | str] | None = None,
    when: int | str | None = None,
    after: str | None = None,
    every: str | None = None,
) -> Written:
    """Give a brick an impulse.

    brick: the brick
    impulse: [x, y, z] in the axes of the scene
    point: where it is pushed, from its centre, in the axes of the scene
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    every: from one repetition to the next; default: all at one time
    """
    what_is_written = {"brick": brick, "impulse": impulse, "point": point}
    return written({"push": what_is_written, "at": when, "after": after, "every": every})


def drop(
    *,
    name: str | None = None,
    brick: str | object | None = None,
    onto: str | None = None,
    height: str | None = None,
    rotate: Sequence[int | str] | None = None,
    when: int | str | None = None,
    after: str | None = None,
    every: str | None = None,
) -> Written:
    """Drop a brick onto it.

    name: its name; default: dropped-1 if it is the first impact
    brick: what is dropped; default: the scenario's brick
    onto: the aim: the middle of a level, or of a brick
    height: how far it falls until it meets what it is dropped onto
    rotate: turn about x, then y, then z, the axes of the scene; default: flat, along what it falls onto
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    every: from one repetition to the next; default: all at one time
    """
    what_is_written = {"name": name, "brick": brick, "onto": onto, "height": height, "rotate": rotate}
    return written({"drop": what_is_written, "at": when, "after": after, "every": every})


def move(
    *,
    brick: str | None = None,
    by: Sequence[int | str] | None = None,
    path: Sequence[Sequence[int | str]] | None = None,
    speed: str | None = None,
    held: int | str | None = None,
    slid: bool | None = None,
    when: int | str | None = None,
    after: str | None = None,
    every: str | None = None,
) -> Written:
    """Move a brick by hand.

    brick: the brick
    by: how far, straight, as [x, y, z] in the axes of the scene
    path: the places it goes to, one after another, each from where it is at first; it stops in each
    speed: the most on the way; it sets out and stops smoothly
    held: how long it is held at the end before it is let go
    slid: pushed along level rather than carried: it keeps its weight, and may tip
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    every: from one repetition to the next; default: all at one time
    """
    what_is_written = {"brick": brick, "by": by, "path": path, "speed": speed, "held": held, "slid": slid}
    return written({"move": what_is_written, "at": when, "after": after, "every": every})


def hold(
    *,
    brick: str | None = None,
    for_: str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    every: str | None = None,
) -> Written:
    """Hold a brick where it is.

    brick: the brick
    for_: how long it is held
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    every: from one repetition to the next; default: all at one time
    """
    what_is_written = {"brick": brick, "for": for_}
    return written({"hold": what_is_written, "at": when, "after": after, "every": every})
