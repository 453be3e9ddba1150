"""compas_cra 0.8.0 as an assessor: rigid block equilibrium (`rbe`) and coupled rigid-block analysis (`cra`).

Both look for forces at the corners of contacts that balance every block (Kao et al. 2022,
doi:10.1016/j.cad.2022.103216). `rbe` (Eq. 6) is Coulomb equilibrium that lets contacts pull at a penalty: what stands
needs no pull worth mentioning. `cra` (Eq. 11) demands a small motion besides that presses where forces press and slips
against friction: stricter than Coulomb equilibrium, as it leaves out forces that only self-stress could bring about. It
is not convex, and a solver that gives up is not told from a structure that falls. Friction is an octagon around the
cone: right along the sides of a contact and at 45 degrees to them, and up to 8 % too much between.

Neither knows contacts of edges and corners, nor more than one coefficient of friction.
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
from stability.contacts.detection import contact_with_plane
from stability.engines.protocol import Package
from stability.geometry.box import as_box
from stability.geometry.vectors import add_scaled, body_axes, dot, scale, subtract
from stability.model import Pose
from stability.problem import Contact, Placed, Tolerances

FEWEST_CORNERS = 3  # of a contact that is a face
EDGES = "bricks touch along edges or at corners, and it knows contacts of faces only"
FRICTIONS = "contacts differ in friction, and it knows one coefficient"


class Programme(StrEnum):
    """What is solved."""

    RBE = "rbe"
    CRA = "cra"


@dataclass(frozen=True, slots=True)
class Compas:
    """One of its programs, with the settings that answer best.

    Its lengths are told in smallest sides and its forces in mean weights of a brick, since its tolerances and the
    bounds of its motions are absolute. Its own defaults find no contact between planks, whose areas are too small.
    """

    program: Programme
    neighbours: int = 20  # blocks of which a contact is looked for; the centres nearest to a block
    flatness: float = 1e-3  # smallest sides that faces in contact may be apart
    least_area: float = 1e-5  # of a contact, in squares of the smallest side; a sliver of 0.05 mm is larger
    # Most pull that counts as none, as a share of all the weight. By trial: what stands is left with 2e-5 at most,
    # since the penalty is finite, and what falls pulls by 2e-4 at least.
    pull: float = 5e-5

    @property
    def name(self) -> str:
        """That of the program."""
        return self.program.value

    @property
    def package(self) -> Package:
        """The package itself."""
        return Package("compas_cra", "pip install '.[benchmarks]'")

    def refusal(self, contacts: Sequence[Contact]) -> str:
        """It takes faces on faces, and one coefficient of friction."""
        if any(len(contact.points_W) < FEWEST_CORNERS for contact in contacts):
            return EDGES
        return FRICTIONS if len({contact.law.friction for contact in contacts}) > 1 else ""

    def load(self) -> None:
        """Contacts and programs; the solver comes with them."""
        import compas_cra.algorithms  # noqa: PLC0415 -- the peer is optional
        import compas_cra.equilibrium  # noqa: F401, PLC0415

    def stands(self, scene: Scene) -> bool:
        """Whether it finds forces."""
        assembly = assembled(scene)
        try:
            with redirect_stdout(StringIO()):
                self._solve(assembly, scene.friction)
        except ValueError:
            return False  # it calls infeasible what falls, and fails or gives up in just the same way
        return self.program is Programme.CRA or _largest_pull(assembly) <= self.pull * len(scene.bricks)

    def _solve(self, assembly: Any, friction: float) -> None:  # noqa: ANN401 -- the peer is untyped
        from compas_cra.algorithms import assembly_interfaces_numpy  # noqa: PLC0415 -- the peer is optional
        from compas_cra.equilibrium import cra_solve, rbe_solve  # noqa: PLC0415

        assembly_interfaces_numpy(assembly, nmax=self.neighbours, tmax=self.flatness, amin=self.least_area)
        solve = cra_solve if self.program is Programme.CRA else rbe_solve
        solve(assembly, mu=friction)


ASSESSORS = {program.value: Compas(program) for program in (Programme.CRA, Programme.RBE)}


def assembled(scene: Scene) -> Any:  # noqa: ANN401 -- the peer is untyped
    """The peer's assembly, in its units: the bricks, and a fixed block wherever one touches a plane."""
    from compas.geometry import Box, Frame  # noqa: PLC0415 -- the peer is optional
    from compas_assembly.datastructures import Block  # noqa: PLC0415
    from compas_cra.datastructures import CRA_Assembly  # noqa: PLC0415

    length = min(placed.brick.shape.least_thickness for placed in scene.bricks)
    mass = fmean(placed.brick.mass for placed in scene.bricks)
    assembly, bases = CRA_Assembly(), list(_bases(scene))
    for number, placed in enumerate([*scene.bricks, *bases]):
        along, across, _ = body_axes(placed.pose.orientation)
        size = scale(1.0 / length, as_box(placed.brick.shape, "compas_cra").size)
        block = Block.from_shape(Box(*size, frame=Frame(scale(1.0 / length, placed.pose.position_W), along, across)))
        block.attributes["density"] = placed.brick.mass / mass / prod(size)  # it takes weight for mass
        assembly.add_block(block, node=number)
    assembly.set_boundary_conditions(list(range(len(scene.bricks), len(scene.bricks) + len(bases))))
    return assembly


def _bases(scene: Scene) -> Iterator[Placed]:
    """A twin behind the plane for each brick that touches one.

    The peer looks for contacts only among blocks whose centres are near, so it would not find one large floor.
    """
    for placed in scene.bricks:
        for plane in scene.planes:
            if contact_with_plane(solid(placed), plane, Tolerances()) is not None:
                height = dot(subtract(placed.pose.position_W, plane.point_W), plane.normal_W)
                behind = add_scaled(placed.pose.position_W, -2.0 * height, plane.normal_W)
                yield Placed(placed.brick, Pose(behind, placed.pose.orientation))


def _largest_pull(assembly: Any) -> float:  # noqa: ANN401 -- the peer is untyped
    """In mean weights of a brick."""
    edges = [assembly.graph.edge_attribute(edge, "interfaces") for edge in assembly.graph.edges()]
    return max((float(f["c_nn"]) for interfaces in edges for one in interfaces for f in one.forces), default=0.0)
