"""Random assemblies of random convex solids, with contacts that are known from how each was put, not found afterwards.

A solid stands on level ground with one of its faces, or lies with a face on a face of one that is there already, level
or sloping, or bridges two pillars of one height. Where both faces overlap is worked out as an intersection of
half-planes by Qhull, and whether a solid runs into another one by a linear programme.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import cos, sin

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

from stability.geometry.box import OffCentreBox
from stability.geometry.solid_making import prism, solid_of_corners
from stability.model import GROUND, Brick, ConvexShape, Pose, Vec3
from stability.problem import Placed
from tests.stability.statics.independent import Touch
from tests.turn_of_axes import orientation_of

Array = NDArray[np.float64]
CLEAR = 3e-3  # [m] so far apart at least is what does not touch: beyond 2 % of what any of them is thick
WIDE = 2e-3  # [m] so wide at least is where two faces overlap
TRIES = 40


@dataclass(frozen=True, slots=True)
class Body:
    """A solid in its place, in arrays."""

    placed: Placed
    turn: Array  # (3, 3) from body axes to W
    normals: Array  # (f, 3) in W
    offsets: Array  # (f,) a point x is inside if normals x <= offsets

    @classmethod
    def of(cls, placed: Placed, turn: Array) -> "Body":
        centre, shape = np.array(placed.pose.position_W), placed.brick.shape
        normals = np.array([face.normal for face in shape.faces]) @ turn.T
        corners = np.array(shape.corners) @ turn.T + centre
        offsets = np.array([n @ corners[face.corners[0]] for n, face in zip(normals, shape.faces, strict=True)])
        return cls(placed, turn, normals, offsets)

    def corners(self, face: int) -> Array:
        """(n, 3) of a face, in W [m]."""
        shape = self.placed.brick.shape
        loop = list(shape.faces[face].corners)
        found: Array = np.array(shape.corners)[loop] @ self.turn.T + np.array(self.placed.pose.position_W)
        return found


@dataclass
class Scene:
    """An assembly in the making."""

    rng: np.random.Generator
    friction: float
    bodies: list[Body] = field(default_factory=list)
    touches: list[Touch] = field(default_factory=list)

    @property
    def bricks(self) -> list[Placed]:
        return [body.placed for body in self.bodies]

    def put(  # noqa: PLR0913, PLR0917 -- two faces, and where one lies on the other
        self, shape: ConvexShape, face: int, on: Body | None, on_face: int, at: Array, spin: float
    ) -> Body:
        """A solid with a face on a face of another, or on the ground, one point of it where it is wanted."""
        normal = np.array((0.0, 0.0, 1.0)) if on is None else on.normals[on_face]
        own = np.array(shape.faces[face].normal)
        corners = np.array(shape.corners)[list(shape.faces[face].corners)]
        turn = _spun(normal, spin) @ _to_z(-own)
        placed_at = at - turn @ corners.mean(axis=0)
        # Exactly on the plane, whatever rounding has made of it.
        level = 0.0 if on is None else float(on.offsets[on_face])
        placed_at = placed_at + normal * (level - float((turn @ corners[0] + placed_at) @ normal))
        density = self.rng.uniform(200.0, 3000.0)
        brick = Brick(f"s{len(self.bodies):02d}", shape, density * shape.volume)
        pose = Pose(_vec(placed_at), orientation_of(turn))
        return Body.of(Placed(brick, pose), turn)

    def takes(self, body: Body, touching: Sequence[tuple[Body | None, int, int]]) -> bool:
        """Take a solid in that touches these, with its own face and theirs, and nothing else; whether it does so."""
        grounded = any(on is None for on, _, _ in touching)
        lowest = min(float(body.corners(face)[:, 2].min()) for face in range(len(body.normals)))
        if not grounded and lowest < CLEAR:
            return False
        ons = [on for on, _, _ in touching]
        if any(other not in ons and _gap(body, other) < CLEAR for other in self.bodies):
            return False
        found = []
        for on, face, on_face in touching:
            if _nearly_flush(body, face) or (on is not None and _nearly_flush(on, on_face)):
                return False
            points = body.corners(face) if on is None else _overlap(body, face, on, on_face)
            if points is None:
                return False
            normal = np.array((0.0, 0.0, 1.0)) if on is None else on.normals[on_face]
            along = points[1] - points[0]
            lower = GROUND if on is None else on.placed.brick.id
            ends = tuple(_vec(point) for point in points)
            upper, normal_W = body.placed.brick.id, _vec(normal)
            if on is not None and normal[2] < 0.0:  # hung below an overhang: the pair the other way round
                lower, upper, normal_W = upper, lower, _vec(-normal)
            found.append(Touch(lower, upper, ends, normal_W, _vec(along / np.linalg.norm(along)), self.friction))
        self.bodies.append(body)
        self.touches += found
        return True


def random_assembly(seed: int) -> Scene:
    """One to seven solids."""
    rng = np.random.default_rng(seed)
    scene = Scene(rng, float(rng.uniform(0.1, 0.9)))
    if rng.random() < 0.3:
        _bridge(scene)
    wanted = len(scene.bodies) + int(rng.integers(1, 5))
    for _ in range(TRIES):
        if len(scene.bodies) >= wanted:
            break
        _add(scene)
    return scene


def _bridge(scene: Scene) -> None:
    """Two pillars of one height, and a solid across them."""
    rng = scene.rng
    height, gap = float(rng.uniform(0.03, 0.12)), float(rng.uniform(0.08, 0.14))
    for side in (-0.5, 0.5):
        pillar = prism([(-0.02, 0.0), (0.02, 0.0), (rng.uniform(0.005, 0.02), height), (-0.02, height)], 0.05).shape
        foot = _lowest(pillar)
        scene.takes(scene.put(pillar, foot, None, 0, np.array((side * gap, 0.0, 0.0)), 0.0), [(None, foot, 0)])
    if len(scene.bodies) < 2:
        return
    left, right = scene.bodies
    wide = gap / 2.0 + 0.01
    outline = [
        (-wide * rng.uniform(0.9, 1.6), 0.0),
        (wide * rng.uniform(0.9, 1.6), 0.0),
        (rng.uniform(-wide, wide), 0.05),
    ]
    beam = prism(outline, 0.04).shape
    face = _lowest(beam)
    x = float(rng.normal(0.0, 0.01))
    body = scene.put(beam, face, None, 0, np.array((x, rng.normal(0.0, 0.01), 0.0)), 0.0)
    x, y, z = body.placed.pose.position_W
    body = Body.of(Placed(body.placed.brick, Pose((x, y, z + height), body.placed.pose.orientation)), body.turn)
    scene.takes(body, [(left, face, _highest(left)), (right, face, _highest(right))])


def _add(scene: Scene) -> None:
    rng, shape = scene.rng, _shape(scene.rng)
    face = int(rng.integers(len(shape.faces)))
    if not scene.bodies or rng.random() < 0.25:
        at = np.array((rng.normal(0.0, 0.15), rng.normal(0.0, 0.15), 0.0))
        scene.takes(scene.put(shape, face, None, 0, at, rng.uniform(0.0, 6.3)), [(None, face, 0)])
        return
    on = scene.bodies[int(rng.integers(len(scene.bodies)))]
    up = np.flatnonzero(on.normals[:, 2] > 0.3)
    if not len(up):
        return
    on_face = int(rng.choice(up))
    corners = on.corners(on_face)
    weights = rng.dirichlet(np.ones(len(corners)))
    spread = rng.uniform(0.0, 1.3)
    middle = corners.mean(axis=0)
    at = middle + spread * (weights @ corners - middle)
    body = scene.put(shape, face, on, on_face, at, rng.uniform(0.0, 6.3))
    scene.takes(body, [(on, face, on_face)])


def _shape(rng: np.random.Generator) -> ConvexShape:
    kind = rng.random()
    if kind < 0.3:
        outline = ConvexHull(rng.uniform(0.0, 0.1, (int(rng.integers(3, 8)), 2)))
        return prism([(float(x), float(y)) for x, y in outline.points[outline.vertices]], rng.uniform(0.02, 0.1)).shape
    if kind < 0.5:
        a, b, c = (float(side) for side in rng.uniform(0.02, 0.12, 3))
        x, y, z = (float(rng.uniform(-0.3, 0.3) * side) for side in (a, b, c))
        return OffCentreBox((a, b, c), (x, y, z))
    points = rng.normal(0.0, 0.03, (int(rng.integers(4, 16)), 3)) * rng.uniform(0.5, 1.5, 3)
    return solid_of_corners([_vec(point) for point in points[ConvexHull(points).vertices]]).shape


def _nearly_flush(body: Body, face: int) -> bool:
    """Whether a corner beside a face is so close to its plane that it counts as being in it."""
    shape = body.placed.brick.shape
    others = [n for n in range(len(shape.corners)) if n not in shape.faces[face].corners]
    depths = body.offsets[face] - (np.array(shape.corners)[others] @ body.turn.T) @ body.normals[face]
    depths -= np.array(body.placed.pose.position_W) @ body.normals[face]
    return bool(depths.min() < CLEAR)


def _gap(a: Body, b: Body) -> float:
    """How far all faces of both must be moved outwards until both have a point in common [m]; negative if inwards."""
    normals, offsets = np.concatenate([a.normals, b.normals]), np.concatenate([a.offsets, b.offsets])
    matrix = np.column_stack([normals, np.ones(len(normals))])
    found = linprog([0.0, 0.0, 0.0, -1.0], A_ub=matrix, b_ub=offsets, bounds=[(None, None)] * 4, method="highs")
    return -float(found.x[3])


def _overlap(body: Body, face: int, on: Body, on_face: int) -> Array | None:
    """(n, 3) the corners of what two faces in one plane have in common; None if that is hardly anything."""
    normal = on.normals[on_face]
    frame = _to_z(normal)[:2]
    planes = []
    for one, number in ((body, face), (on, on_face)):
        points = one.corners(number) @ frame.T
        hull = ConvexHull(points)
        planes.append(hull.equations)
    half_planes = np.concatenate(planes)
    matrix = np.column_stack([half_planes[:, :2], np.linalg.norm(half_planes[:, :2], axis=1)])
    found = linprog([0.0, 0.0, -1.0], A_ub=matrix, b_ub=-half_planes[:, 2], bounds=[(None, None)] * 3, method="highs")
    if found.x is None or found.x[2] < WIDE / 2.0:
        return None
    corners = HalfspaceIntersection(half_planes, found.x[:2]).intersections
    around = corners[ConvexHull(corners).vertices]
    height = float(on.offsets[on_face])
    flat: Array = around @ frame + height * normal
    # Of the plane, what is along the normal only: the frame goes through the origin of W.
    return flat


def _to_z(normal: Array) -> Array:
    """A turn (3, 3) that takes a unit vector to z; its first rows span the plane across it."""
    helper = np.array((1.0, 0.0, 0.0)) if abs(normal[0]) < 0.7 else np.array((0.0, 1.0, 0.0))
    first = np.cross(helper, normal)
    first /= np.linalg.norm(first)
    return np.array((first, np.cross(normal, first), normal))


def _spun(normal: Array, angle: float) -> Array:
    """A turn that takes z to a unit vector, after one about z."""
    about = np.array(((cos(angle), -sin(angle), 0.0), (sin(angle), cos(angle), 0.0), (0.0, 0.0, 1.0)))
    turn: Array = _to_z(normal).T @ about
    return turn


def _lowest(shape: ConvexShape) -> int:
    return int(np.argmin([face.normal[2] for face in shape.faces]))


def _highest(body: Body) -> int:
    return int(np.argmax(body.normals[:, 2]))


def _vec(parts: Array | Sequence[float]) -> Vec3:
    x, y, z = (float(part) for part in parts)
    return (x, y, z)
