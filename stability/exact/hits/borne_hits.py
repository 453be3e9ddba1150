"""Which hits does friction stop before the brick that is struck has moved by anything? For these nothing is woken.

A hit is taken as plastic: the two bricks go on with the speed that they share at the point where they meet, and as long
as the one pushes the other, both are stopped by what rubs on the one that lies in the structure. What is left of their
energy along the normal, by friction times the mean way of the rubbing faces, is how far that brick goes. Below a limit
it may as well be held fixed: the other one is stopped by it all the same.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import dist, sqrt

from stability.engines.edge_normals import velocity_at
from stability.exact.hits.holding import Holding
from stability.exact.hits.overload import MOVED, slides_before_it_tips
from stability.geometry.rotations import body_axes, inverse, rotate
from stability.geometry.touching import TOUCHING
from stability.geometry.vectors import add, add_scaled, dot, norm, scale, subtract
from stability.mechanics.impulse import pushed
from stability.model import AT_REST, BodyState, Brick, Pose, Vec3
from stability.shapes.box import Box
from stability.shapes.in_pose import corners_W, reach_W
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed
from stability.watching.approach import Hit

AT_ONCE = TOUCHING  # share of the smallest side: corners no further back than this arrive with the foremost
FLUSH = 0.125  # share of the smallest side: what is so near to a face, and goes on as far as it, covers it
LEVEL = 1.0 - 1e-6  # vertical part of a normal; on a contact that is less level, friction is not all that holds
LEVEL_HIT = 0.02  # vertical part of the normal of a hit that comes from the side
ROUNDING = 1e-9  # of a unit normal
# Of a line that moves in its own plane, the mean speed over the root of the mean square is at least this.
MEAN_BY_ROOT = 0.816


@dataclass(frozen=True, slots=True)
class Flying:
    """A brick that is about to hit another one."""

    brick: Brick
    state: BodyState


def friction_stops(assembly: Assembly, hit: Hit, flying: Flying, beside: Sequence[Placed], holding: Holding) -> bool:
    """Whether a hit on a brick of an assembly moves it by less than what counts; `beside`: other bricks near it.

    Of boxes only: what any other solid meets, and how, is left to an engine.
    """
    struck = assembly.bricks[hit.brick]
    if not all(isinstance(brick.shape, Box) for brick in (flying.brick, struck.brick, *(one.brick for one in beside))):
        return False
    contacts = assembly.contacts(hit.brick)
    lies_flat = all(abs(normal[2]) >= LEVEL for contact in contacts for normal in contact.normals_W)
    friction = min([contact.friction for contact in contacts], default=0.0)
    if not lies_flat or friction <= 0.0 or not slides_before_it_tips(struck, friction):
        return False
    normal_W, at_W, speed = _as_it_meets(hit, flying, struck, beside)
    if speed <= 0.0:
        return True
    own = _mass_at(flying.brick, flying.state.pose, at_W, normal_W)
    other = _mass_at(struck.brick, struck.pose, _point_hit(struck, at_W, normal_W), normal_W)
    shared = speed * own / (own + other)
    energy = 0.5 * (own + other) * shared * shared
    mean_way = MEAN_BY_ROOT * sqrt(min(1.0, other / struck.brick.mass))  # for a unit of way at the point that is hit
    enough = energy / (mean_way * min(1.0, friction) * MOVED * struck.brick.shape.least_thickness)
    return holding.at_least(assembly, hit.brick, enough)


def _as_it_meets(hit: Hit, flying: Flying, struck: Placed, beside: Sequence[Placed]) -> tuple[Vec3, Vec3, float]:
    """The normal of a hit [unit, W], the point that meets the struck brick [m, W], and the speed there [m/s].

    Where the next brick lies flush on a face, nothing comes onto the edge of that face: it meets the faces beside it.
    """
    at_W, open_W = _foremost(flying, hit.normal_W), (0.0, 0.0, 0.0)
    for axis_W in body_axes(struck.pose.orientation):
        inwards = dot(hit.normal_W, axis_W)
        outwards_W = scale(-1.0 if inwards > 0.0 else 1.0, axis_W)
        if abs(inwards) > ROUNDING and not _is_covered(struck, beside, at_W, outwards_W):
            open_W = add_scaled(open_W, inwards, axis_W)
    size = norm(open_W)
    if size >= 1.0 - ROUNDING or size <= ROUNDING:
        return hit.normal_W, at_W, hit.speed
    normal_W = scale(1.0 / size, open_W)
    at_W = _foremost(flying, normal_W)
    return normal_W, at_W, dot(velocity_at(flying.state, at_W), normal_W)


def _foremost(flying: Flying, along_W: Vec3) -> Vec3:
    """The point of a brick that goes ahead along a direction: a corner, or that of several which is most in its way."""
    reached = sorted(((dot(c, along_W), c) for c in corners_W(flying.brick.shape, flying.state.pose)), reverse=True)
    within = AT_ONCE * flying.brick.shape.least_thickness
    ahead = [corner for reach, corner in reached if reach >= reached[0][0] - within]
    centre_W = flying.state.pose.position_W
    if len(ahead) == 1:
        return ahead[0]
    if len(ahead) == 2:  # noqa: PLR2004 -- an edge
        return _on_edge(ahead[0], ahead[1], centre_W, along_W)
    return add_scaled(centre_W, reached[0][0] - dot(centre_W, along_W), along_W)


def _on_edge(one_W: Vec3, other_W: Vec3, centre_W: Vec3, along_W: Vec3) -> Vec3:
    """The point of an edge that passes nearest to a line through the centre."""
    edge, lever = subtract(other_W, one_W), subtract(centre_W, one_W)
    across = add_scaled(edge, -dot(edge, along_W), along_W)
    length = dot(across, across)
    part = dot(lever, across) / length if length > 0.0 else 0.5
    return add_scaled(one_W, max(0.0, min(1.0, part)), edge)


def _is_covered(struck: Placed, beside: Sequence[Placed], at_W: Vec3, outwards_W: Vec3) -> bool:
    """Whether another brick goes on where a face of a brick ends, as far out as where something comes."""
    near, nearest_W = reach_beside(struck), _nearest(struck, at_W)
    inside = dot(subtract(nearest_W, struck.pose.position_W), outwards_W)
    to_face = reach_W(struck.brick.shape, struck.pose, outwards_W) - inside
    beyond_W = add_scaled(nearest_W, to_face + near, outwards_W)
    return any(dist(_nearest(other, beyond_W), beyond_W) <= near for other in beside)


def reach_beside(struck: Placed) -> float:
    """How near to a brick others are beside it [m]."""
    return FLUSH * struck.brick.shape.least_thickness


def _point_hit(struck: Placed, at_W: Vec3, normal_W: Vec3) -> Vec3:
    """Where a brick that lies flat is hit. From the side it slides before it tips, so the height does not matter."""
    x, y, z = _nearest(struck, at_W)
    return (x, y, struck.pose.position_W[2] if abs(normal_W[2]) <= LEVEL_HIT else z)


def _nearest(placed: Placed, point_W: Vec3) -> Vec3:
    """The point of the box about a brick that is nearest to a point [m, W]."""
    turn, shape = placed.pose.orientation, placed.brick.shape
    x, y, z = rotate(inverse(turn), subtract(point_W, placed.pose.position_W))
    a, b, c = (shape.reach(axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    within = (max(-a, min(a, x)), max(-b, min(b, y)), max(-c, min(c, z)))
    return add(placed.pose.position_W, rotate(turn, within))


def _mass_at(brick: Brick, pose: Pose, at_W: Vec3, along_W: Vec3) -> float:
    """The impulse [N s] that gives a point of a free brick at rest a unit of speed along a direction."""
    moving = pushed(BodyState(pose, AT_REST, AT_REST), brick, along_W, at_W)
    return 1.0 / dot(velocity_at(moving, at_W), along_W)
