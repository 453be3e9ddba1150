"""Build steps with single bricks, and with the boxes of a file."""

from collections.abc import Mapping, Sequence

from stackdsl.api.arguments import with_remedy
from stackdsl.api.written import Part, Written, written


@with_remedy('such as brick(name="a", on="ground")')
def brick(
    *,
    at: Sequence[str] | None = None,
    stud: Sequence[int | str] | None = None,
    turned: bool | None = None,
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
    """Return one brick in any pose: `at` a position, on a `stud`, `on` other bricks, or `beside` one.

    at: position [x, y, z] of its centre
    stud: for a brick with studs: its lowest x and y in studs, and its underside, such as `2 bricks` or `4 plates`
    turned: whether the length of a brick with `stud` is along y
    on: the brick or bricks below, or the ground; the brick lies on top, at the mean of their centres
    beside: the brick that it touches from the side, with its bottom at the same height
    towards: direction from the brick of `beside` to this one: 0 deg = +x, 90 deg = +y
    offset: additional shift [x, y, z], along the axes of the scene
    rotate: rotation about x, then y, then z, the axes of the scene
    name: its name; default: by position, such as L3.2
    brick: brick type; default: that of the step, or else of the scenario
    level: its level; default: derived from its height
    friction: its own Coulomb coefficient; default: that of its type
    drop: whether it is released in the air instead of being set down
    """
    place = {"at": at, "stud": stud, "turned": turned, "on": on, "beside": beside, "towards": towards, "offset": offset}
    others = {"rotate": rotate, "brick": brick, "level": level, "friction": friction, "drop": drop}
    return written({"name": name, **place, **others}, Part.BRICK)


@with_remedy('such as bricks([brick(name="a", on="ground")])')
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
    """Return a build step that sets down single bricks. The parameters are the keys of every step; `when` is `at`."""
    what = {"bricks": each, "name": name, "brick": brick}
    return written({**what, "at": when, "after": after, "every": every, "place": place, "jitter": jitter}, Part.LAYOUT)


@with_remedy('such as imported("pallet.csv", point="corner")')
def imported(
    file: str,
    *,
    format: str | None = None,
    load: str | None = None,
    settle: str | None = None,
    point: str | None = None,
    map_: Mapping[str, str] | None = None,
    decimals: str | None = None,
    encoding: str | None = None,
    units: Mapping[str, str] | None = None,
    density: str | None = None,
    up: str | None = None,
    supports: str | None = None,
    library: str | None = None,
    strength: Mapping[str, str] | None = None,
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
    """Return a build step with the boxes of a file of another program. The path is relative to the calling file.

    format: format of the file; default: detected from its content
    load: number of the pallet or order, if the file has several loads
    settle: how boxes are lowered onto their supports: `as written`, `down`, or within a gap, such as `within 5 mm`
    point: for a table: the point of a box that x, y, z refer to, `corner` (the lowest one) or `centre`
    map_: for a table: headers of columns that have other names, such as {"length": "L"}
    decimals: for a table: `point` or `comma`, where the numbers leave it open
    encoding: for a table: `windows-1252`, in which spreadsheets write text files; default: `utf-8`
    units: units of columns whose headers have none, and of mesh and COMPAS files, which have none
    density: for a mesh or COMPAS file: density of all blocks
    up: for an OBJ, STL or PLY file: the axis that points up
    supports: for a COMPAS file: `bricks` imports the fixed blocks as bricks
    library: for a StableLego or APEX-MR file: the file with the sizes and masses of its bricks
    strength: strength of every brick of the file against crushing, such as {"stack": "60 kg"}
    deck: deck of the pallet; boxes that overhang it are reported, and with a `surface` it is built as a brick; default:
        that of the file
    origin: shift [x, y, z] of the load
    ignore: columns, keys or bodies of the file to leave out
    """
    kept = {"file": file, "format": format, "load": load, "settle": settle}
    left_open = {"point": point, "units": units, "density": density, "up": up, "supports": supports, "library": library}
    others = {
        "map": map_,
        "decimals": decimals,
        "encoding": encoding,
        "strength": strength,
        "deck": deck,
        "origin": origin,
        "ignore": ignore,
    }
    step = {"at": when, "after": after, "name": name, "every": every, "place": place, "jitter": jitter}
    return written({"import": written({**kept, **left_open, **others}), **step}, Part.LAYOUT)
