"""Reads a file of COMPAS as an assembly of exact statics, like `import`, with fixed bodies as supports."""

from collections.abc import Collection
from dataclasses import replace
from math import cos, inf, sin
from pathlib import Path

from stability.geometry.box import Box
from stability.geometry.compound_making import FramedCompound, compound
from stability.geometry.solid_making import FramedSolid, solid_of_corners
from stability.geometry.vectors import add, rotate
from stability.model import Brick, Pose, Vec3
from stability.problem import Placed
from stability.statics.assembly import LEVEL_GROUND, Assembly
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import Exact3, ImportedBox, ImportedLoad
from stackdsl.language.imports import Import


def own_assembly(path: Path, supports: Collection[int], friction: float, turn: float) -> tuple[Assembly, list[Placed]]:
    """Return supports and blocks to place, rotated about y [rad]. Raises UnreadableLoadError."""
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
    return assembly_of(load, {f"block-{node}" for node in supports}, friction, turn)


def assembly_of(
    load: ImportedLoad, fixed: Collection[str], friction: float, turn: float = 0.0
) -> tuple[Assembly, list[Placed]]:
    """Return fixed and other blocks of a load, rotated about y [rad]; they stand on the ground if none is fixed."""
    bricks = [_placed(box, turn) for box in load.boxes]
    tables = [each for each in bricks if each.brick.id in fixed]
    planes = () if tables else (replace(LEVEL_GROUND, friction=friction),)
    return Assembly(planes, friction, tables=tables, overlap=inf), [
        each for each in bricks if each.brick.id not in fixed
    ]


def _placed(box: ImportedBox, turn: float) -> Placed:
    assert box.name is not None
    about = (0.0, sin(0.5 * turn), 0.0, cos(0.5 * turn))
    centre = _floats(box.centre)
    if box.corners is None:
        return Placed(Brick(box.name, Box(_floats(box.size)), float(box.mass)), Pose(rotate(about, centre), about))
    made: FramedSolid | FramedCompound
    if box.parts is None:
        made = solid_of_corners([_floats(corner) for corner in box.corners])
    else:
        solids = [solid_of_corners([_floats(corner) for corner in part]) for part in box.parts]
        made = compound([(solid.shape, Pose(solid.centre_of_mass)) for solid in solids])
    place = rotate(about, add(centre, made.centre_of_mass))
    return Placed(Brick(box.name, made.shape, float(box.mass)), Pose(place, about))


def _floats(parts: Exact3) -> Vec3:
    x, y, z = map(float, parts)
    return (x, y, z)
