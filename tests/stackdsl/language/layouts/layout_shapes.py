"""Shapes of layouts for tests of them: levels, gaps, and whether exact statics let them stand."""

from collections import defaultdict
from collections.abc import Sequence
from math import prod

from stability.geometry.box import Box
from stability.geometry.box_distance import boxes_apart
from stability.model import Brick, Plane
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly
from stackdsl.compiler.bricks import pose_of
from stackdsl.language.bricks import CATALOGUE
from stackdsl.language.layouts.registry import BrickSpec

KAPLA = CATALOGUE["kapla"].size
LENGTH, WIDTH, THICKNESS = KAPLA


def by_level(specs: Sequence[BrickSpec]) -> list[list[BrickSpec]]:
    levels = defaultdict(list)
    for spec in specs:
        levels[spec.level].append(spec)
    return [levels[level] for level in sorted(levels)]


def gap(one: BrickSpec, other: BrickSpec) -> float:
    return boxes_apart(KAPLA, pose_of(one), KAPLA, pose_of(other)).gap


def standing(friction: float, specs: Sequence[BrickSpec]) -> Assembly:
    """An empty assembly with this friction throughout, and the bricks of a layout set down in it moment by moment."""
    assembly = Assembly([Plane("ground", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction)], friction)
    moments: list[list[Placed]] = []
    for number, spec in enumerate(specs):
        size = spec.size or KAPLA
        mass = 0.0119 * prod(size) / prod(KAPLA)
        placed = Placed(Brick(f"{number:03}", Box(size), mass), pose_of(spec))
        moments = [*moments[:-1], [*moments[-1], placed]] if spec.together else [*moments, [placed]]
    for moment in moments:
        if assembly.add_all(moment).stability is not Stability.STABLE:
            break
    return assembly
