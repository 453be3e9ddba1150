"""Single bricks, bricks from a file, and the steps of the build that set them down."""

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
    """Return a brick at a place `at`, `on` other bricks or `beside` one, in any pose.

    at: [x, y, z] of its centre
    on: the brick or bricks on which it lies, centred over the mean of their centres; or the ground
    beside: the brick that it touches from the side, at the same height of the bottom
    towards: direction from the brick `beside` it: 0 deg = +x, 90 deg = +y
    offset: shifts it from there by [x, y, z], in the axes of the scene
    rotate: rotation about x, then y, then z, the axes of the scene
    name: its name; default: by place, such as L3.2
    brick: its kind; default: the brick of the step, or else of the scenario
    level: its level; default: from its height
    friction: its own Coulomb coefficient; default: that of its kind
    drop: release it in the air instead of setting it down
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
    """Return a step of the build that sets down bricks one by one; the keys are those of any step."""
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
    """Return a step of the build with the boxes of a file of another program; its path is relative to the calling file.

    format: format of the file; default: detected
    load: one of several loads: number of the pallet, or of the order
    settle: contact with the boxes below: as written, down, or such as within 5 mm
    point: of a table: the point of a box given by x, y, z, its lower corner or its centre
    units: of columns without a unit in the header, or of an OBJ or COMPAS file, which has none
    density: of an OBJ or COMPAS file: of all blocks in it
    up: of an OBJ file: the axis that points up
    supports: of a COMPAS file: `bricks` imports the blocks marked as fixed like other bricks
    deck: the deck of the pallet; overhanging boxes are reported; default: that of the file
    origin: shifts the load by [x, y, z]
    ignore: parts of the file that are not imported: columns, keys, or bodies
    """
    kept = {"file": file, "format": format, "load": load, "settle": settle}
    left_open = {"point": point, "units": units, "density": density, "up": up, "supports": supports}
    others = {"deck": deck, "origin": origin, "ignore": ignore}
    step = {"at": when, "after": after, "name": name, "every": every, "place": place, "jitter": jitter}
    return written({"import": written({**kept, **left_open, **others}), **step})
