"""KAPLA planks as tests of hits put them up, without language and compiler."""

from collections.abc import Iterable, Mapping

from stability.geometry.box import Box
from stability.model import GROUND, BodyId, Brick, Plane, Pose, Quaternion, Vec3
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly

SIZE = LENGTH, WIDTH, THICKNESS = (0.1176, 0.0234, 0.0078)  # [m]
MASS = 0.012  # [kg]
GRAVITY = 9.81  # [m/s2]
WOOD = 0.5  # coefficient of friction
ALONG: Quaternion = (0.0, 0.0, 0.0, 1.0)  # the length along x
ACROSS: Quaternion = (0.0, 0.0, 0.5**0.5, 0.5**0.5)  # the length along y
FLOOR = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), WOOD)


def plank(name: BodyId, size: Vec3 = SIZE) -> Brick:
    return Brick(name, Box(size), MASS)


def lying(level: int, x: float = 0.0, y: float = 0.0, turn: Quaternion = ALONG) -> Pose:
    """A plank that lies flat as high as this level, counted from 1."""
    return Pose((x, y, (level - 0.5) * THICKNESS), turn)


def four_stack(levels: Iterable[int], x: float = 0.0) -> dict[BodyId, Pose]:
    """Two planks a level, flush with the ends of those below; odd levels along x, number 2 towards +x or +y."""
    aside = (LENGTH - WIDTH) / 2.0
    return {
        f"L{level}.{number}": lying(level, x, side) if level % 2 else lying(level, x + side, 0.0, ACROSS)
        for level in levels
        for number, side in enumerate((-aside, aside), 1)
    }


def column(levels: int) -> dict[BodyId, Pose]:
    """One plank on the other."""
    return {f"L{level}": lying(level) for level in range(1, levels + 1)}


def standing(poses: Mapping[BodyId, Pose], floor: Plane = FLOOR) -> Assembly:
    """Planks that are proven to stand."""
    assembly = Assembly((floor,), WOOD, GRAVITY)
    assert assembly.add_all(Placed(plank(name), pose) for name, pose in poses.items()).stability is Stability.STABLE
    return assembly
