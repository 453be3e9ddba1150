"""A file of COMPAS as an assembly of exact statics: as `import` reads it, but for supports, which never move."""

from collections.abc import Collection
from math import cos, sin
from pathlib import Path

from stability.geometry.rotations import rotate
from stability.geometry.vectors import add, subtract
from stability.model import Brick, Pose
from stability.shapes.solid_making import solid_of_corners
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed
from stackdsl.importing.load import ImportedBox
from stackdsl.importing.load_formats import read_load
from stackdsl.language.imports import Import


def own_assembly(path: Path, supports: Collection[int], friction: float, turn: float) -> tuple[Assembly, list[Placed]]:
    """Supports in place and the blocks that are to come, turned about y [rad]. Raises UnreadableLoadError."""
    asked = Import.model_validate(
        {
            "file": path.name,
            "format": "compas",
            "units": {"length": "m"},
            "density": "1000 kg/m3",
            "supports": "bricks",
        }
    )
    load = read_load(path.read_bytes(), path.name, asked)
    fixed = {f"block-{node}" for node in supports}
    bricks = [_placed(box, turn) for box in load.boxes]
    tables = [each for each in bricks if each.brick.id in fixed]
    return Assembly((), friction, tables=tables), [each for each in bricks if each.brick.id not in fixed]


def _placed(box: ImportedBox, turn: float) -> Placed:
    assert box.corners is not None
    assert box.name is not None
    made = solid_of_corners([(float(x), float(y), float(z)) for x, y, z in box.corners])
    about = (0.0, sin(0.5 * turn), 0.0, cos(0.5 * turn))
    x, y, z = map(float, box.centre)
    centre = rotate(about, add((x, y, z), subtract(made.centre_of_mass, (0.0, 0.0, 0.0))))
    return Placed(Brick(box.name, made.shape, float(box.mass)), Pose(centre, about))
