"""Measures errors of contacts of planks edge on edge: friction limits, landings and planks tipped against each other.

Three kinds of planks: planks that stay sharp, planks of `exact` (sharp when placed square, and rounded when they come
to lean edge on edge), and rounded ones. Closed forms: an inverted V stands if the friction is at least (cot a - t / L)
/ 2, also after a drop (an impact scales all forces alike, as weight does); a plank with its centre over the crossing of
two edges stops dead. Run it with `python -m benchmarks.edges`; about two minutes.
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import product
from math import atan2, cos, hypot, inf, pi, radians, sin, sqrt, tan

from rich.console import Console
from rich.table import Table

from stability.engines.edge_normals import wrong_normals
from stability.engines.pybullet import PyBulletWorld
from stability.engines.pybullet.bodies import BrickBodies
from stability.engines.pybullet.contacts import EdgeReshaper
from stability.engines.pybullet.groups import WeldedGroups
from stability.engines.pybullet.settings import PyBulletSettings
from stability.geometry.box import Box
from stability.geometry.vectors import about, multiply, rotate
from stability.model import GROUND, BodyId, BodyState, Brick, Plane, Pose, Quaternion, Vec3
from stackdsl.simulation.systems import MOVING

GRAVITY, DENSITY, USUAL = 9.81, 557.0, 0.1176  # [m/s2], [kg/m3], length for which the settings are tuned [m]
KAPLA: Vec3 = (USUAL, 0.0234, 0.0078)
SIZES = {"1 cm": (0.01, 0.002, 0.00066), "KAPLA": KAPLA, "20 cm": (0.2, 0.04, 0.0133)}  # [m]
RATES, HEIGHTS = (480, 960, 1920), (0.0, 0.01, 0.1)  # [1/s], [m]
KINDS = ("sharp", "exact", "rounded")
ANGLE = radians(70.0)  # of the V to the ground
SHARES = (0.97, 1.01, 1.03, 1.1, 1.3, 1.6, 2.0, 2.3, 2.6, 3.0)  # of the required friction
SPIN = 2.0  # [rad/s] of the tipped planks
CROSSINGS = (0.0, 0.3, 1.0, 3.0, 10.0, 90.0)  # angles between edges in contact [deg]


class KeptEdges:
    """Reshaper that keeps the edges of bricks as they were placed."""

    def __init__(self, bricks: BrickBodies, groups: WeldedGroups) -> None:
        """Accept and ignore the bricks."""

    def reshape(self, states: Mapping[BodyId, BodyState]) -> None:
        """Change nothing."""


@dataclass(frozen=True, slots=True)
class Scene:
    """Common parameters of all runs of a row."""

    size: Vec3
    rate: int  # [1/s]
    kind: str
    friction: float

    @property
    def settings(self) -> PyBulletSettings:
        """Return the settings of `exact` at this rate."""
        lively = (MOVING.lively_speed or 0.0) * sqrt(self.size[0] / USUAL)
        return replace(MOVING, time_step=1.0 / self.rate, lively_speed=lively)

    @property
    def brick_mass(self) -> float:
        """The mass of a plank [kg]."""
        length, width, thickness = self.size
        return DENSITY * length * width * thickness

    @contextmanager
    def opened(self, ground: float = 0.0) -> Iterator[PyBulletWorld]:
        """Open a world with the ground at a height [m]."""
        reshaper = KeptEdges if self.kind == "sharp" else EdgeReshaper
        engine = PyBulletWorld.opened(self.settings, GRAVITY, self.friction, self.brick_mass, reshaper)
        try:
            engine.add_plane(Plane(GROUND, (0.0, 0.0, ground), (0.0, 0.0, 1.0), self.friction))
            yield engine
        finally:
            engine.close()

    def add(self, engine: PyBulletWorld, name: str, pose: Pose) -> None:
        """Place a plank; one that is not rounded is placed square elsewhere first."""
        brick = Brick(name, Box(self.size), self.brick_mass)
        if self.kind == "rounded":
            engine.add_brick(brick, pose)
        else:
            engine.add_brick(brick, Pose((20.0 * self.size[0], 0.0, pose.position_W[2])))
            engine.put_at(name, pose)


def main() -> None:
    """Measure and print the tables."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    console = Console(width=120)
    console.print(v_limits())
    console.print(landings())
    console.print(tipped())


def v_limits() -> Table:
    """Return the share of the required friction from which an inverted V stands, for each kind of planks."""
    table = Table("V at 70 deg, friction asked for / needed", "drop mm", *(f"1/{rate} s" for rate in RATES))
    for (name, size), kind, height in product(SIZES.items(), KINDS, HEIGHTS):
        scaled = height * size[0] / USUAL
        found = [next(_standing(size, rate, kind, scaled), inf) for rate in RATES]
        table.add_row(f"{name}, {kind}", f"{1000.0 * scaled:g}", *(f"{share:g}" for share in found))
    return table


def _standing(size: Vec3, rate: int, kind: str, height: float) -> Iterator[float]:
    needed = (1.0 / tan(ANGLE) - size[2] / size[0]) / 2.0
    for share in SHARES:
        if _v_stands(Scene(size, rate, kind, share * needed), height):
            yield share


def v_pose(size: Vec3, angle: float, side: float, height: float = 0.0) -> Pose:
    """Return the pose of a plank that leans on the plane x = 0, with its lower edge at a height [m].

    It leans from the left for a `side` of -1, else from the right.
    """
    length, _, thick = size
    x = side * (length * cos(angle) + thick * sin(angle)) / 2.0
    z = (length * sin(angle) + thick * cos(angle)) / 2.0 + height
    return Pose((x, 0.0, z), (0.0, side * sin(angle / 2.0), 0.0, cos(angle / 2.0)))


def _v_stands(scene: Scene, height: float) -> bool:
    with scene.opened() as engine:
        for name, side in (("left", -1.0), ("right", 1.0)):
            scene.add(engine, name, v_pose(scene.size, ANGLE, side, height))
        speed = sqrt(2.0 * GRAVITY * height)
        _played(engine, speed / GRAVITY + sqrt(scene.size[0] / USUAL), speed)
        return _at_height(engine, "left", v_pose(scene.size, ANGLE, -1.0).position_W[2], 0.02 * scene.size[0])


def _played(engine: PyBulletWorld, seconds: float, fastest: float) -> None:
    engine.set_max_speed(fastest + 0.1)
    for _ in range(round(seconds * engine.settings.time_step**-1)):
        engine.step()


def _at_height(engine: PyBulletWorld, name: str, height: float, within: float) -> bool:
    return abs(engine.states([name])[name].pose.position_W[2] - height) < within


def landings() -> Table:
    """Return the share of speed that a plank keeps after falling onto an edge of another; it should be zero."""
    table = Table("KAPLA onto an edge: speed kept, %", "drop mm", *(f"{crossing:g} deg" for crossing in CROSSINGS))
    for kind, height in product(KINDS, HEIGHTS[1:]):
        kept = [100.0 * _speed_kept(Scene(KAPLA, 960, kind, 0.2), radians(c), height) for c in CROSSINGS]
        table.add_row(kind, f"{1000.0 * height:g}", *(f"{share:.1f}" for share in kept))
    return table


def _speed_kept(scene: Scene, crossing: float, height: float) -> float:
    with scene.opened(ground=-1.0) as engine:
        _, width, thick = scene.size
        upright = pi / 2.0 - atan2(thick, width)  # a corner of its section is vertically below the centre
        half = (0.0, width / 2.0, thick / 2.0)
        lower, upper = _about_x(upright), multiply(_about_z(crossing), _about_x(upright))
        top = max(rotate(lower, (0.0, y * half[1], z * half[2]))[2] for y in (-1, 1) for z in (-1, 1))
        scene.add(engine, "lower", Pose((0.0, 0.0, -top), lower))
        engine.freeze("lower")
        scene.add(engine, "upper", Pose((0.0, 0.0, top + height), upper))
        speed = sqrt(2.0 * GRAVITY * height)
        _played(engine, speed / GRAVITY + 2.0 / scene.rate, speed)
        return hypot(*engine.states(["upper"])["upper"].velocity_W) / speed


def _about_x(angle: float) -> Quaternion:
    return about((1.0, 0.0, 0.0), angle)


def _about_z(angle: float) -> Quaternion:
    return about((0.0, 0.0, 1.0), angle)


def tipped() -> Table:
    """Return the number of pairs of tipped upright planks that do not end as a V, although statics allows it."""
    meets, frictions = (60.0, 65.0, 70.0, 75.0), (0.3, 0.4, 0.5, 0.6)
    table = Table(
        "tipped at 2 rad/s, meet at 60 to 75 deg", *(f"1/{rate} s" for rate in RATES), "looks with wrong normals"
    )
    for kind in KINDS:
        slipped, wrong = [], 0
        for rate in RATES:
            runs = [_tip(Scene(KAPLA, rate, kind, mu), radians(meet)) for meet, mu in product(meets, frictions)]
            slipped.append(f"{sum(not stood for stood, _ in runs)} of {len(runs)}")
            wrong += sum(looks for _, looks in runs)
        table.add_row(kind, *slipped, f"{wrong}")
    return table


def _tip(scene: Scene, meet: float) -> tuple[bool, int]:
    """Return whether both planks stand in the end, and the number of samples with a wrong normal."""
    names: Sequence[str] = ("left", "right")
    with scene.opened() as engine:
        for name, side in zip(names, (-1.0, 1.0), strict=True):
            _set_upright(engine, scene, name, side, meet)
        wrong = 0
        for _ in range(100):
            _played(engine, 0.01, 1.0)
            wrong += any(True for _ in wrong_normals(engine, engine.states(names), GRAVITY))
        height = v_pose(scene.size, meet, 1.0).position_W[2]
        return all(_at_height(engine, name, height, 0.02 * scene.size[0]) for name in names), wrong


def _set_upright(engine: PyBulletWorld, scene: Scene, name: str, side: float, meet: float) -> None:
    length, _, thick = scene.size
    foot = side * length * cos(meet)
    upright = pi / 2.0 if scene.kind != "rounded" else radians(89.8)
    pose = v_pose(scene.size, upright, side)
    aside = side * (thick * sin(upright) - length * cos(upright)) / 2.0
    pose = Pose((foot + aside, 0.0, pose.position_W[2]), pose.orientation)
    engine.add_brick(Brick(name, Box(scene.size), scene.brick_mass), pose)
    turn = -side * SPIN  # about y, at the foot's inner edge
    engine.bodies.set_motion(name, (turn * pose.position_W[2], 0.0, -turn * aside), (0.0, turn, 0.0))


if __name__ == "__main__":
    main()
