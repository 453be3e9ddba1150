"""compas_cra 0.8.0 as an assessor: rigid block equilibrium (`rbe`) and coupled rigid-block analysis (`cra`).

Both search for forces at the corners of contacts that balance every block (Kao et al. 2022,
doi:10.1016/j.cad.2022.103216). `rbe` (Eq. 6) is Coulomb equilibrium in which contacts may pull at a penalty: a standing
structure needs no significant pull. `cra` (Eq. 11) also requires a small motion that compresses contacts under pressure
and slips against friction: this is stricter than Coulomb equilibrium, as it excludes forces that only self-stress could
cause. It is not convex, and a solver failure cannot be distinguished from a fall. Friction is an octagon around the
cone: exact along the sides of a contact and at 45 degrees to them, and up to 8 % too large between.

Neither supports contacts of edges and corners, nor more than one coefficient of friction.
"""

from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from enum import StrEnum
from io import StringIO
from math import prod
from statistics import fmean
from typing import Any

from benchmarks.systems.assessment import Scene
from stability.contacts.bodies import solid
from stability.contacts.detection import contacts_with_plane
from stability.engines.protocol import Package
from stability.geometry.box import as_box
from stability.geometry.vectors import add_scaled, body_axes, dot, scale, subtract
from stability.model import Pose
from stability.problem import Contact, Placed, Tolerances

FEWEST_CORNERS = 3  # of a face contact
EDGES = "bricks touch along edges or at corners, and it knows contacts of faces only"
FRICTIONS = "contacts differ in friction, and it knows one coefficient"


class Programme(StrEnum):
    """Program to solve."""

    RBE = "rbe"
    CRA = "cra"


@dataclass(frozen=True, slots=True)
class Compas:
    """One of its programs, with the settings that give the best answers.

    Its lengths are in units of the smallest side and its forces in units of the mean weight of a brick, since its
    tolerances and the bounds of its motions are absolute. With its default settings it finds no contact between planks,
    whose areas are too small.
    """

    program: Programme
    neighbours: int = 20  # number of blocks, nearest first, that are tested for contact with a block
    flatness: float = 1e-3  # largest distance of faces in contact, in smallest sides
    least_area: float = 1e-5  # of a contact, in squares of the smallest side; a sliver of 0.05 mm is larger
    # Largest pull that counts as zero, as a share of the total weight. By trial: standing structures keep at most 2e-5,
    # since the penalty is finite, and falling ones pull by at least 2e-4.
    pull: float = 5e-5

    @property
    def name(self) -> str:
        """Return the name of the program."""
        return self.program.value

    @property
    def package(self) -> Package:
        """Return the compas_cra package."""
        return Package("compas_cra", "pip install '.[benchmarks]'")

    def refusal(self, contacts: Sequence[Contact]) -> str:
        """Refuse contacts other than faces on faces, and several coefficients of friction."""
        if any(len(contact.points_W) < FEWEST_CORNERS for contact in contacts):
            return EDGES
        return FRICTIONS if len({contact.law.friction for contact in contacts}) > 1 else ""

    def load(self) -> None:
        """Import contact detection and programs, including the solver."""
        import compas_cra.algorithms  # noqa: PLC0415 -- the peer is optional
        import compas_cra.equilibrium  # noqa: F401, PLC0415

    def stands(self, scene: Scene) -> bool:
        """Return whether it finds forces."""
        assembly = assembled(scene)
        try:
            with redirect_stdout(StringIO()):
                self._solve(assembly, scene.friction)
        except ValueError:
            return False  # infeasible means a fall; failures are reported in the same way
        return self.program is Programme.CRA or largest_pull(assembly) <= self.pull * len(scene.bricks)

    def _solve(self, assembly: Any, friction: float) -> None:  # noqa: ANN401 -- the peer is untyped
        from compas_cra.algorithms import assembly_interfaces_numpy  # noqa: PLC0415 -- the peer is optional
        from compas_cra.equilibrium import cra_solve, rbe_solve  # noqa: PLC0415

        assembly_interfaces_numpy(assembly, nmax=self.neighbours, tmax=self.flatness, amin=self.least_area)
        solve = cra_solve if self.program is Programme.CRA else rbe_solve
        solve(assembly, mu=friction)


ASSESSORS = {program.value: Compas(program) for program in (Programme.CRA, Programme.RBE)}


def assembled(scene: Scene) -> Any:  # noqa: ANN401 -- the peer is untyped
    """Return the peer's assembly in its units: the bricks, and a fixed block at each contact with a plane."""
    from compas.geometry import Box, Frame  # noqa: PLC0415 -- the peer is optional
    from compas_assembly.datastructures import Block  # noqa: PLC0415
    from compas_cra.datastructures import CRA_Assembly  # noqa: PLC0415

    length = min(placed.brick.shape.least_thickness for placed in scene.bricks)
    mass = fmean(placed.brick.mass for placed in scene.bricks)
    assembly, fixed = CRA_Assembly(), list(bases(scene))
    for number, placed in enumerate([*scene.bricks, *fixed]):
        along, across, _ = body_axes(placed.pose.orientation)
        size = scale(1.0 / length, as_box(placed.brick.shape, "compas_cra").size)
        block = Block.from_shape(Box(*size, frame=Frame(scale(1.0 / length, placed.pose.position_W), along, across)))
        block.attributes["density"] = placed.brick.mass / mass / prod(size)  # the peer uses the weight as mass
        assembly.add_block(block, node=number)
    assembly.set_boundary_conditions(list(range(len(scene.bricks), len(scene.bricks) + len(fixed))))
    return assembly


def bases(scene: Scene) -> Iterator[Placed]:
    """Yield a copy behind the plane for each brick that touches one.

    compas_cra tests contacts only among blocks with near centres, so it would not find one large floor.
    """
    for placed in scene.bricks:
        for plane in scene.planes:
            if contacts_with_plane(solid(placed), plane, Tolerances()):
                height = dot(subtract(placed.pose.position_W, plane.point_W), plane.normal_W)
                behind = add_scaled(placed.pose.position_W, -2.0 * height, plane.normal_W)
                yield Placed(placed.brick, Pose(behind, placed.pose.orientation))


def largest_pull(assembly: Any) -> float:  # noqa: ANN401 -- the peer is untyped
    """Return the largest pull in mean weights of a brick."""
    edges = [assembly.graph.edge_attribute(edge, "interfaces") for edge in assembly.graph.edges()]
    return max((float(f["c_nn"]) for interfaces in edges for one in interfaces for f in one.forces), default=0.0)
