"""Which bricks of a timeline are so far apart that each others' motion cannot matter before somebody would see it come?

Seen from above, every brick is given room for as far as it may get by toppling, and somewhat more. Where a line along
x or y runs through no room of any, it parts those on either side, and these are parted further likewise.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from stability.geometry.vectors import add_scaled, dot, subtract
from stability.model import Plane, Vec3
from stackdsl.timeline import Arrival, Handled, Placement, Shake, Timeline

MOST: Final = 8  # parts of a scene; an engine takes 28 MB, and 15 ms to open
ROLLS: Final = 4.0  # times its half diagonal that a brick may go beyond its height above the ground

Stretch = tuple[float, float]


@dataclass(frozen=True, slots=True)
class _Room:
    """Where a brick may get by itself, in plan."""

    number: int  # of its placement
    along: tuple[Stretch, Stretch]  # x and y [m]


def far_apart(timeline: Timeline) -> list[list[Placement]]:
    """The placements of a timeline in parts, each in the order of time, and the parts in that of their first ones.

    All are one part where hands are at work or the ground shakes, which concerns all. Beyond `MOST` the last part has
    what is left, however far apart that is.
    """
    placements = timeline.placements
    if any(isinstance(action, Handled | Shake) for action in timeline.actions) or any(
        placement.arrival is Arrival.BY_HAND for placement in placements
    ):
        return [list(placements)]
    ground = timeline.world.planes[0]
    found = sorted(_parted([_room(number, each, ground) for number, each in enumerate(placements)]))
    if len(found) > MOST:
        found[MOST - 1 :] = [sorted(number for part in found[MOST - 1 :] for number in part)]
    return [[placements[number] for number in part] for part in found]


def _room(number: int, placement: Placement, ground: Plane) -> _Room:
    """Where a brick stands, or comes from, or is thrown to, and how far it may topple from there."""
    radius = placement.brick.shape.bounding_radius
    came = placement.came or placement.pose
    aim_W = add_scaled(came.position_W, placement.flight, placement.velocity_W)
    places = [_about(position_W, radius, ground) for position_W in (placement.pose.position_W, came.position_W, aim_W)]
    (low_x, high_x), (low_y, high_y) = (
        (min(place[axis][0] for place in places), max(place[axis][1] for place in places)) for axis in (0, 1)
    )
    return _Room(number, ((low_x, high_x), (low_y, high_y)))


def _about(position_W: Vec3, radius: float, ground: Plane) -> tuple[Stretch, Stretch]:
    height = max(0.0, dot(subtract(position_W, ground.point_W), ground.normal_W))
    reach = height + (1.0 + ROLLS) * radius
    x, y, _ = position_W
    return (x - reach, x + reach), (y - reach, y + reach)


def _parted(rooms: Sequence[_Room]) -> list[list[int]]:
    """The numbers of those that no line parts, in order."""
    for axis in (0, 1):
        groups = list(_cut(rooms, axis))
        if len(groups) > 1:
            return [part for group in groups for part in _parted(group)]
    return [sorted(room.number for room in rooms)]


def _cut(rooms: Iterable[_Room], axis: int) -> Iterable[list[_Room]]:
    """Those between gaps along an axis."""
    group: list[_Room] = []
    until = 0.0
    for room in sorted(rooms, key=lambda room: room.along[axis]):
        low, high = room.along[axis]
        if group and low > until:
            yield group
            group = []
        until = max(until, high) if group else high
        group.append(room)
    if group:
        yield group
