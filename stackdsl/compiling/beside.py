"""Where a brick lies that is placed by another one: `on` it, or `beside` it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import cos, fsum, sin

from stability.geometry.rotations import inverse, rotate
from stability.geometry.vectors import dot, subtract
from stability.model import GROUND, BodyId, ConvexShape, Plane, Pose, Quaternion, Vec3
from stability.shapes.apart import in_place
from stackdsl.compiling.standing import Standing
from stackdsl.compiling.written_bricks import DIGITS, NowhereError, WrittenBrick
from stackdsl.language.bricks import SetBrick


@dataclass(slots=True)
class Surroundings:
    """What bricks may be placed by: all that the author put before them."""

    planes: Sequence[Plane]
    standing: Standing = field(init=False)
    named: dict[BodyId, int] = field(default_factory=dict)  # by the author
    seen: int = 0  # bricks whose own names are known

    def __post_init__(self) -> None:
        self.standing = Standing(self.planes)

    def place_of(
        self, brick: SetBrick, shape: ConvexShape, turned: Quaternion, before: Sequence[WrittenBrick]
    ) -> tuple[Vec3, tuple[int, ...]]:
        """The centre of mass of a brick, and the bricks that it is placed by, by number. Raises NowhereError."""
        names = brick.on or ((brick.beside,) if brick.beside is not None else ())
        numbers = tuple(self._number(name, before) for name in names if name != GROUND)
        own = in_place(shape, Pose((0.0, 0.0, 0.0), turned))
        others = [in_place(before[number].shape, before[number].pose) for number in numbers]
        centres = [other.middle_W for other in others] or [(0.0, 0.0, 0.0)]
        x, y = (fsum(centre[axis] for centre in centres) / len(centres) for axis in (0, 1))
        top = max((other.high_W[2] for other in others), default=0.0)
        if brick.beside is not None:
            toward = (cos(brick.towards), sin(brick.towards), 0.0)
            apart = _reach(shape, turned, (-toward[0], -toward[1], 0.0)) + dot(own.middle_W, toward)
            other = before[numbers[0]]
            apart += _reach(other.shape, other.pose.orientation, toward)
            apart -= dot(subtract(others[0].middle_W, other.pose.position_W), toward)
            x, y, top = x + apart * toward[0], y + apart * toward[1], others[0].low_W[2]
        (dx, dy, dz), (mx, my, _) = brick.offset, own.middle_W
        place = (x - mx + dx, y - my + dy, top - own.low_W[2] + dz)
        return (round(place[0], DIGITS), round(place[1], DIGITS), round(place[2], DIGITS)), numbers

    def _number(self, name: BodyId, before: Sequence[WrittenBrick]) -> int:
        """The number of an earlier brick. Its name by place is worked out only if none is called so by its author."""
        for number in range(self.seen, len(before)):
            if (own := before[number].name) is not None:
                self.named.setdefault(own, number)
        self.seen = len(before)
        if name in self.named:
            return self.named[name]
        self.standing.take_in(before, name)
        if name not in self.standing.named:
            raise NowhereError(name)
        return self.standing.named[name]


def _reach(shape: ConvexShape, turned: Quaternion, direction: Vec3) -> float:
    """How far a shape reaches from its centre in a direction of the scene [m]."""
    return shape.reach(rotate(inverse(turned), direction))


def later_names(written: Sequence[WrittenBrick]) -> Mapping[BodyId, WrittenBrick]:
    """All bricks that their authors named."""
    return {brick.name: brick for brick in written if brick.name is not None}
