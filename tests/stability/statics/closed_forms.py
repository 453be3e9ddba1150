"""Structures whose limit of standing is known in closed form, each at a `share` of that limit.

Below a share of one a structure stands, above it it falls. Every limit is derived here from the balance of forces and
moments, none is fitted. t thickness, L length, mu friction, theta the angle to the level; weights are in kilograms.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import atan, atan2, cos, pi, sin

from stability.geometry.box import Box
from stability.model import GROUND, Brick, Plane, Pose, Quaternion, Vec3
from stability.problem import Placed

LENGTH, WIDTH, THICKNESS = 0.1176, 0.0234, 0.0078  # a KAPLA plank [m]
PLANK: Vec3 = (LENGTH, WIDTH, THICKNESS)
DENSITY = 557.0  # [kg/m3]


@dataclass(frozen=True, slots=True)
class Structure:
    """Bricks in their places, what they stand on, and the friction between them."""

    bricks: tuple[Placed, ...]
    planes: tuple[Plane, ...]
    friction: float = 0.5  # brick on brick


def level_ground(friction: float = 0.5) -> Plane:
    """The plane z = 0."""
    return Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), friction)


def brick_at(
    name: str, size: Vec3, centre: Vec3, turn: Quaternion = (0.0, 0.0, 0.0, 1.0), mass: float | None = None
) -> Placed:
    """A brick with its centre there [m]; of wood if its mass [kg] is not given."""
    weight = DENSITY * size[0] * size[1] * size[2] if mass is None else mass
    return Placed(Brick(name, Box(size), weight), Pose(centre, turn))


def stepped_column(share: float, count: int) -> Structure:
    """`count` planks, each shifted by d along its length from the one below.

    Those above plank j, counted from the bottom, have their common centre (count - j + 1) d / 2 from the centre of j,
    which ends at L / 2. The lowest joint is the strictest: count d <= L.
    """
    step = share * LENGTH / count
    bricks = [brick_at(f"c{k:03}", PLANK, (k * step, 0.0, (k + 0.5) * THICKNESS)) for k in range(count)]
    return Structure(tuple(bricks), (level_ground(),))


def column_of_masses(share: float, masses: Sequence[float]) -> Structure:
    """A stepped column of planks of these masses, from the bottom; share of the step d.

    What is above plank j has its centre d (sum of m_i (i - j)) / (sum of m_i) from the centre of j, over all i > j: at
    most L / 2. One joint is the strictest.
    """
    reaches = []
    for j in range(len(masses) - 1):
        above = masses[j + 1 :]
        reaches.append(sum(mass * (k + 1) for k, mass in enumerate(above)) / sum(above))
    step = share * 0.5 * LENGTH / max(reaches)
    return Structure(
        tuple(
            brick_at(f"c{k:03}", PLANK, (k * step, 0.0, (k + 0.5) * THICKNESS), mass=mass)
            for k, mass in enumerate(masses)
        ),
        (level_ground(),),
    )


def harmonic_stack(share: float, count: int) -> Structure:
    """`count` planks on one more, each reaching as far beyond the one below as it may.

    Joint i from the top is at its limit when the centre of the i planks above it is above the end of the plank below.
    That centre is i - 1 parts at the end of plank i (where joint i - 1 is at its limit) and one part at its middle:
    L / (2 i) from the end of plank i. So plank i reaches L / (2 i) beyond plank i + 1, all joints at once.
    """
    bricks, x = [], 0.0
    for level in range(count + 1):
        bricks.append(brick_at(f"h{level:03}", PLANK, (x, 0.0, (level + 0.5) * THICKNESS)))
        if level < count:
            x += share * 0.5 * LENGTH / (count - level)
    return Structure(tuple(bricks), (level_ground(),))


def ladder(share: float, floor: float = 0.4, wall: float = 0.0) -> Structure:
    """A plank that leans on a wall, its lower face's edges touching floor and wall; share of cot theta.

    With normal forces N (floor) and H (wall), friction F at the floor and V up the wall: H = F, N = W - V, and about
    the foot W (L cos - t sin) / 2 = H L sin + V L cos. Slipping, F = floor N and V = wall H, so H = floor W / (1 +
    floor wall), and with c = cot theta:   (c - t / L) (1 + floor wall) = 2 floor (1 + wall c), which gives the limit
        c = (2 floor + (t / L) (1 + floor wall)) / (1 - floor wall);  on a smooth wall c = 2 floor + t / L.
    """
    slim = THICKNESS / LENGTH
    theta = atan2(1.0, share * (2.0 * floor + slim * (1.0 + floor * wall)) / (1.0 - floor * wall))
    plank = leaning("ladder", theta)
    planes = (level_ground(floor), Plane("wall", (LENGTH * cos(theta), 0.0, 0.0), (-1.0, 0.0, 0.0), wall))
    return Structure((plank,), planes)


def inverted_v(share: float, theta: float = pi / 3.0) -> Structure:
    """Two planks that lean against each other with the upper edges of their lower faces; share of 1 / mu.

    By symmetry they press level on each other, with H. About a foot W (L cos - t sin) / 2 = H L sin, and a foot, which
    carries W, slips unless H <= mu W:   mu >= (cot theta - t / L) / 2.
    """
    friction = 0.5 * (cos(theta) / sin(theta) - THICKNESS / LENGTH) / share
    left = leaning("left", theta)
    x, y, z = left.pose.position_W
    mirrored = (0.0, -sin(0.5 * (pi - theta)), 0.0, cos(0.5 * (pi - theta)))
    right = brick_at("right", PLANK, (2.0 * LENGTH * cos(theta) - x, y, z), mirrored)
    return Structure((left, right), (level_ground(friction),), friction)


def leaning(name: str, theta: float) -> Placed:
    """A plank that rises towards +x from the origin, where its lower face ends."""
    x = 0.5 * (LENGTH * cos(theta) - THICKNESS * sin(theta))
    z = 0.5 * (LENGTH * sin(theta) + THICKNESS * cos(theta))
    return brick_at(name, PLANK, (x, 0.0, z), (0.0, -sin(0.5 * theta), 0.0, cos(0.5 * theta)))


def slope_that_slides(share: float, friction: float = 0.5) -> Structure:
    """A plank flat on a slope; share of tan. The slope pulls with W sin, friction holds mu W cos: tan <= mu."""
    return on_slope(PLANK, atan(share * friction), friction)


def slope_that_tips(share: float, base: float = 0.0234, height: float = 0.1176) -> Structure:
    """A block upright on a rough slope; share of tan. Its centre is above its lower edge at tan = base / height."""
    return on_slope((base, WIDTH, height), atan(share * base / height), friction=2.0)


def on_slope(size: Vec3, angle: float, friction: float) -> Structure:
    """A block on a slope that falls towards +x."""
    normal = (sin(angle), 0.0, cos(angle))
    centre = (0.5 * size[2] * normal[0], 0.0, 0.5 * size[2] * normal[2])
    block = brick_at("block", size, centre, (0.0, sin(0.5 * angle), 0.0, cos(0.5 * angle)))
    return Structure((block,), (Plane(GROUND, (0.0, 0.0, 0.0), normal, friction),))


def counterweighted_overhang(share: float, counterweight: float = 0.03) -> Structure:
    """A plank that reaches too far over the end of its base, held down by a weight; share of the overhang x.

    The plank, of mass m, turns about the end of the base unless the counterweight M on it, y behind that end, holds it:
    m x <= M y. (x is how far the plank's centre is beyond the end; without a counterweight it falls for any x > 0.)
    """
    side, behind = 0.01, 0.015
    plank_mass = DENSITY * LENGTH * WIDTH * THICKNESS
    beyond = share * counterweight * behind / plank_mass
    bricks = (
        brick_at("base", (0.06, WIDTH, 0.03), (-0.03, 0.0, 0.015)),
        brick_at("plank", PLANK, (beyond, 0.0, 0.03 + 0.5 * THICKNESS)),
        brick_at("weight", (side, side, side), (-behind, 0.0, 0.03 + THICKNESS + 0.5 * side), mass=counterweight),
    )
    return Structure(bricks, (level_ground(),))


def bridge(share: float, friction: float = 0.5) -> Structure:
    """Two blocks, each too far over the inner end of its pier, tied by a beam across both; share of their overhang e.

    A block of mass m and height t turns about the inner end of its pier, and its top moves inwards. The beam, of mass
    M, stops that by friction: it presses M / 2 down on each block and holds it back by at most mu M / 2. It may press
    anywhere on the block, best at its own end, q inwards of the pivot. About the pivot:
        m e + (M / 2) q <= mu (M / 2) t,   so   e <= (M / (2 m)) (mu t - q).
    Two mirrored halves: with any balance its mirror image and their mean balance too, so each half carries M / 2. The
    beam is in compression, pier and block do not slip (less than mu (m + M / 2) is asked for), and the pier is broad.
    """
    height, inwards, block_mass, beam_mass = 0.04, 0.004, 0.05, 0.08
    pivot, pier = 0.08, (0.16, 0.06, 0.03)
    beyond = share * beam_mass / (2.0 * block_mass) * (friction * height - inwards)
    bricks = [brick_at("beam", (2.0 * (pivot - inwards), 0.02, 0.01), (0.0, 0.0, 0.075), mass=beam_mass)]
    for side, name in ((-1.0, "left"), (1.0, "right")):
        bricks += [
            brick_at(f"pier {name}", pier, (side * (pivot + 0.08), 0.0, 0.015), mass=1.0),
            brick_at(f"block {name}", (0.06, 0.03, height), (side * (pivot - beyond), 0.0, 0.05), mass=block_mass),
        ]
    return Structure(tuple(bricks), (level_ground(friction),), friction)


def wedged_plank(friction: float = 0.5) -> Structure:
    """A level plank between two walls exactly its length apart, and nothing below it.

    Any level force H >= W / (2 mu) between the walls would balance it, but nothing says that it is there.
    """
    walls = (
        Plane("wall1", (-0.5 * LENGTH, 0.0, 0.0), (1.0, 0.0, 0.0), friction),
        Plane("wall2", (0.5 * LENGTH, 0.0, 0.0), (-1.0, 0.0, 0.0), friction),
    )
    return Structure((brick_at("plank", PLANK, (0.0, 0.0, 0.2)),), walls, friction)


def three_legs(share: float) -> Structure:
    """A plate on three posts, loaded beyond one side of the triangle; share of the load's reach."""
    posts = ((-0.04, -0.03), (0.04, -0.03), (0.0, 0.04))
    # The side between the first two posts runs along their outer faces, y = -0.03 - 0.005; through x = 0.01 of it.
    return _plate_on_posts(share, [(x, y, 0.005) for x, y in posts], open_side=(0.01, -0.035))


def four_unequal_supports(share: float) -> Structure:
    """A plate on four posts of unequal size and place, loaded beyond one side of their hull; share of the load's reach.

    The side runs from the right end of one post to the right end of another, (0.05, -0.02) to (0.04, 0.032), with every
    other corner to the left of it. It is crossed at its middle.
    """
    posts = ((-0.04, -0.03, 0.004), (0.043, -0.027, 0.007), (0.035, 0.027, 0.005), (-0.02, 0.035, 0.006))
    return _plate_on_posts(share, posts, open_side=(0.045, 0.006))


def _plate_on_posts(
    share: float, posts: Iterable[tuple[float, float, float]], open_side: tuple[float, float]
) -> Structure:
    """A plate of mass m, its centre at the origin, on posts (x, y, half width), and a load of mass M on it.

    Vertical forces balance while the common centre of plate and load is in the hull of the posts. With the load at p, a
    point of the hull's border at s, and the plate's centre at 0: (M p) / (m + M) = s, so p = s (m + M) / M.
    """
    plate, load, height = 0.2, 0.5, 0.03
    bricks = [
        brick_at(f"post{number}", (2.0 * half, 2.0 * half, height), (x, y, 0.5 * height))
        for number, (x, y, half) in enumerate(posts)
    ]
    x, y = (share * s * (plate + load) / load for s in open_side)
    bricks.append(brick_at("plate", (0.16, 0.14, 0.01), (0.0, 0.0, height + 0.005), mass=plate))
    bricks.append(brick_at("load", (0.006, 0.006, 0.006), (x, y, height + 0.013), mass=load))
    return Structure(tuple(bricks), (level_ground(),))
