"""LMGC90 as an assessor: non-smooth contact dynamics in time steps (Jean 1999, doi:10.1016/S0045-7825(98)00383-1).

It is used through compas_lmgc90 0.1.11. LMGC90 moves the blocks by an implicit scheme with Coulomb friction and
inelastic impacts (its law IQS_CLB), so its answer is a motion: blocks that hardly moved after half a second are taken
to stand. Its gravity is 9.81 m/s2 along -z. Blocks are convex and of uniform density, and one friction holds for all.

The package needs neither of its dependencies on viewers for this: pip install --no-deps compas_lmgc90==0.1.11
"""

from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from typing import TypeAlias

import numpy as np
from scipy.spatial import ConvexHull

from benchmarks.systems.assessment import Scene
from benchmarks.systems.compas import FRICTIONS, bases
from stability.engines.protocol import Package
from stability.geometry.placed_shape import corners_W
from stability.geometry.rows import Array
from stability.model import Vec3
from stability.problem import Contact, Placed

FIXED = ("Vx", "Vy", "Vz", "Rx", "Ry", "Rz")
Faces: TypeAlias = list[list[int]]


@dataclass(frozen=True, slots=True)
class Block:
    """A convex block as LMGC90 reads it."""

    corners: Sequence[Vec3]  # [m, W]
    faces: Faces  # indices of corners, counter-clockwise seen from outside
    density: float  # [kg/m3]
    fixed: bool = False


@dataclass(frozen=True, slots=True)
class Lmgc90:
    """The solver with its settings.

    Its examples take steps of 10 ms, in which contacts overlap: a column of 20 planks at 0.95 of its limit falls.
    """

    step: float = 0.002  # [s]
    steps: int = 250
    law: str = "IQS_CLB"
    moved: float = 0.02  # share of the extent of a block: a block that moved further does not stand

    @property
    def name(self) -> str:
        """Return the displayed name."""
        return "lmgc90"

    @property
    def package(self) -> Package:
        """Return the compas_lmgc90 package."""
        return Package("compas_lmgc90", "pip install --no-deps compas_lmgc90==0.1.11")

    def refusal(self, contacts: Sequence[Contact]) -> str:
        """Refuse several coefficients of friction."""
        return FRICTIONS if len({contact.law.friction for contact in contacts}) > 1 else ""

    def load(self) -> None:
        """Import the solver."""
        import compas_lmgc90.solver  # noqa: F401, PLC0415 -- the peer is optional

    def stands(self, scene: Scene) -> bool:
        """Return whether no brick moves."""
        fixed = [block_of(placed, fixed=True) for placed in bases(scene)]
        return self.largest_move([*map(block_of, scene.bricks), *fixed], scene.friction) <= self.moved

    def largest_move(self, blocks: Sequence[Block], friction: float) -> float:
        """Return the largest move of a corner of a block after all steps, as a share of the extent of the block."""
        from compas_lmgc90.solver import Solver  # noqa: PLC0415 -- the peer is optional

        with redirect_stdout(StringIO()):
            solver = Solver(dt=self.step)
            solver.geometry_from_v_f(
                [{"vertices": [*map(list, block.corners)], "faces": block.faces} for block in blocks],
                density=[block.density for block in blocks],
            )
            for number, block in enumerate(blocks):
                for component in FIXED if block.fixed else ():
                    solver.apply_velocity(number, component, 0.0)
            solver.contact_law(self.law, friction)
            solver.preprocess()
            solver.run(self.steps)
        moves = (
            _share(np.array(block.corners), np.array(mesh.vertices_attributes("xyz")))
            for block, mesh in zip(blocks, solver.trimeshes, strict=True)
        )
        return max(moves)


def block_of(placed: Placed, *, fixed: bool = False) -> Block:
    """Return a convex brick as a block: its corners, and the triangles of its hull."""
    shape = placed.brick.shape
    corners = corners_W(shape, placed.pose)
    return Block(corners, outward_triangles(corners), placed.brick.mass / shape.volume, fixed)


def outward_triangles(corners: Sequence[Vec3]) -> Faces:
    """Return the triangles of the hull of corners, counter-clockwise seen from outside."""
    hull = ConvexHull(np.array(corners))
    middle = hull.points.mean(axis=0)
    faces = []
    for triangle in hull.simplices:
        a, b, c = hull.points[triangle]
        inward = float(np.dot(np.cross(b - a, c - a), a - middle)) < 0.0
        faces.append([*map(int, triangle[::-1] if inward else triangle)])
    return faces


def _share(before: Array, after: Array) -> float:
    extent = float(np.ptp(before, axis=0).max())
    return float(np.linalg.norm(after - before, axis=1).max()) / extent
