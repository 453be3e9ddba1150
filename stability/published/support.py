"""The published base model: does the centre of mass of a brick and of all that it carries lie above its contact?

Source: the stack-stability thesis, sections 3.3.4 to 3.3.6; equation numbers below are its own. Its assumptions:
- Friction between bricks of the stack is infinite, so only tipping is tested.
- Nothing in the stack stands on a brick that is not in the stack.
- A brick that could rest wholly on one support does, even if it touches more (merge case 1). Where it could rest on
  any of several alike, for its centre of mass lies over the joint between them, none is that one, and these share.
- Over more than two supports the weight is shared equally, each part at com above (merge case 2).
- Over two supports, each share is found as if the other support's nearest contact point were a pivot (merge case 3).
  The two shares keep neither the load nor its moment: supports far apart are given less than it, close together more,
  and stacks that lean out lose moment about the edge that they tip over. The model is kept so.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from stability.geometry.plan import Point2, Polygon, signed_distance
from stability.graph import from_the_top
from stability.model import BodyId, Vec3
from stability.published.contact_areas import ContactArea
from stability.published.merging import Share, equal_shares, shares_of_two
from stability.published.readings import AS_READ, Readings

ON_THE_BORDER = 1e-9  # [m] a centre of mass this close outside still counts as above: the limit itself is neutral


@dataclass(frozen=True, slots=True)
class StackedBrick:
    """A brick of the stack and what it stands on. Its supports were in the stack before it."""

    id: BodyId
    mass: float  # [kg]
    com_W: Vec3  # [m]
    areas: tuple[ContactArea, ...]  # one a support; none if it leans, for what it leans on is kept elsewhere
    main: Polygon  # hull over all supports

    @property
    def rests_on(self) -> tuple[BodyId, ...]:
        """The supports, the ground included."""
        return tuple(area.on for area in self.areas)


@dataclass(frozen=True, slots=True)
class Load:
    """What a brick carries, itself included: mass above [kg] and com above, in plan [m]."""

    mass: float
    com: Point2

    def plus(self, mass: float, at: Point2) -> "Load":
        """This load and another one: Eq. 1 and 2, and with an equivalent mass Eq. 10 and 11."""
        total = self.mass + mass
        x = (self.com[0] * self.mass + at[0] * mass) / total
        y = (self.com[1] * self.mass + at[1] * mass) / total
        return Load(total, (x, y))


def lies_above(com: Point2, contact: Polygon) -> bool:
    """Section 3.3.4: does a ray from the centre of mass straight down hit the contact?"""
    return signed_distance(com, contact) >= -ON_THE_BORDER


def shares(load: Load, areas: tuple[ContactArea, ...], readings: Readings = AS_READ) -> tuple[Share, ...]:
    """How a load is distributed over the supports: single branch, or one of the three merge cases of section 3.3.6.

    A brick that leans has no areas of this kind, and passes nothing on.
    """
    if len(areas) <= 1:
        return tuple(Share(area.on, load.mass, load.com) for area in areas)
    depths = [signed_distance(load.com, area.polygon) for area in areas]
    if max(depths) >= -ON_THE_BORDER:
        # No name decides: within the border on both sides of a joint, either support could bear it.
        areas = tuple(a for a, depth in zip(areas, depths, strict=True) if depth >= max(depths) - 2.0 * ON_THE_BORDER)
    if len(areas) == 1:
        return (Share(areas[0].on, load.mass, load.com),)
    if len(areas) > 2:  # noqa: PLR2004 -- merge case 2
        return tuple(equal_shares(load.mass, load.com, areas, readings))
    one, other = areas
    return tuple(shares_of_two(load.mass, load.com, one, other, readings))


def loads_above(stack: Mapping[BodyId, StackedBrick], readings: Readings = AS_READ) -> dict[BodyId, Load]:
    """Mass above and com above of every brick, from the top down (single, split and merge branches alike)."""
    loads = {name: Load(brick.mass, (brick.com_W[0], brick.com_W[1])) for name, brick in stack.items()}
    for name in from_the_top({name: brick.rests_on for name, brick in stack.items()}):
        for share in shares(loads[name], stack[name].areas, readings):
            if share.on in loads:
                loads[share.on] = loads[share.on].plus(share.mass, share.at)
    return loads


def tipping_margin(brick: StackedBrick, load: Load) -> float:
    """How far com above lies inside the main contact [m]; negative if it tips."""
    return signed_distance(load.com, brick.main)


def failing(stack: Mapping[BodyId, StackedBrick], loads: Mapping[BodyId, Load]) -> tuple[BodyId, ...]:
    """The stack test of section 3.3.5: every brick whose com above is not above its main contact, by name."""
    resting = (name for name in sorted(stack) if stack[name].areas)
    return tuple(name for name in resting if not lies_above(loads[name].com, stack[name].main))
