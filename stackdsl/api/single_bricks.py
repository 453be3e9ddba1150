"""Bricks one by one or out of a file, and the step of the build that sets them down."""

from collections.abc import Mapping, Sequence

from stackdsl.api.written import Written, written


def brick(
    *,
    at: Sequence[str] | None = None,
    on: str | Sequence[str] | None = None,
    beside: str | None = None,
    towards: str | None = None,
    offset: Sequence[str] | None = None,
    rotate: Sequence[str] | None = None,
    name: str | None = None,
    brick: str | Mapping[str, object] | None = None,
    level: int | None = None,
    friction: float | str | None = None,
    drop: bool | None = None,
) -> Written:
    """One brick in any pose, `at` a place, `on` other bricks or `beside` one.

    at: [x, y, z] of its centre
    on: the brick, or bricks, on whose top it lies, in the middle of their centres; or the ground
    beside: the brick that it stands beside, touching it, as low as that
    towards: where it stands, seen from what it is beside: 0 deg = +x, 90 deg = +y
    offset: shifts it from there by [x, y, z], in the axes of the scene
    rotate: turn about x, then y, then z, the axes of the scene
    name: its name; default: by place, such as L3.2
    brick: what it is; default: the brick of the step, or else of the scenario
    level: its level; default: judged by its height
    friction: Coulomb coefficient of its own; default: of what it is
    drop: let go in the air, rather than set down
    """
    place = {"at": at, "on": on, "beside": beside, "towards": towards, "offset": offset}
    others = {"rotate": rotate, "brick": brick, "level": level, "friction": friction, "drop": drop}
    return written({"name": name, **place, **others})


def bricks(
    each: Sequence[Written],
    *,
    when: str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | Mapping[str, object] | None = None,
    every: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """A step of the build that sets down bricks one by one; the keys are those of any step."""
    what = {"bricks": each, "name": name, "brick": brick}
    return written({**what, "at": when, "after": after, "every": every, "place": place, "jitter": jitter})


def imported(
    file: str,
    *,
    format: str | None = None,
    load: str | None = None,
    settle: str | None = None,
    point: str | None = None,
    units: Mapping[str, str] | None = None,
    density: str | None = None,
    up: str | None = None,
    supports: str | None = None,
    deck: str | Mapping[str, object] | None = None,
    origin: Sequence[str] | None = None,
    ignore: Sequence[str] | None = None,
    when: str | None = None,
    after: str | None = None,
    name: str | None = None,
    every: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """A step of the build with the boxes of a file that another program wrote, as seen from the calling file.

    format: what it is; default: what it cannot but be
    load: which of several loads: number of the pallet, or of the order
    settle: how boxes come to touch what is below them: as written, down, or such as within 5 mm
    point: of a table: what x, y, z are of a box, its lower corner or its centre
    units: of columns whose headers say none, or of an OBJ or COMPAS file, which never does
    density: of an OBJ or COMPAS file: of all blocks in it
    up: of an OBJ file: which of its axes points up
    supports: of a COMPAS file: `bricks` takes the blocks that it says are fixed as bricks like others
    deck: the deck of its pallet, of which what overhangs is told; default: what the file says
    origin: shifts the load by [x, y, z]
    ignore: what the file has beside, and is not to be taken: columns, keys, or bodies
    """
    kept = {"file": file, "format": format, "load": load, "settle": settle}
    left_open = {"point": point, "units": units, "density": density, "up": up, "supports": supports}
    others = {"deck": deck, "origin": origin, "ignore": ignore}
    step = {"at": when, "after": after, "name": name, "every": every, "place": place, "jitter": jitter}
    return written({"import": written({**kept, **left_open, **others}), **step})
