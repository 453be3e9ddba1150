"""Would what stands still stand under loads besides its weight?"""

from collections.abc import Mapping
from dataclasses import replace

from stability.geometry.vectors import add
from stability.model import BodyId
from stability.statics.assembly import Assembly
from stability.statics.facts import Wrench

MOST = 60  # bricks in one program: a few milliseconds


def withstands(assembly: Assembly, loads: Mapping[BodyId, Wrench]) -> bool:
    """Whether forces are proven to balance all that is connected with the loaded bricks; False if that is not known.

    Loads are at the centres of the bricks, in W. Far from them, bricks are held fixed where there are too many.
    """
    from stability.statics.solvers.equilibrium import balance  # noqa: PLC0415 -- it brings numpy, and what stands does without

    group = _connected(assembly, sorted(loads))
    problem = assembly.problem(group)
    together = {
        brick: Wrench(add(own.force_W, loads[brick].force_W), add(own.torque_W, loads[brick].torque_W))
        if brick in loads
        else own
        for brick, own in problem.loads.items()
    }
    return balance(replace(problem, loads=together)).forces is not None


def _connected(assembly: Assembly, bricks: list[BodyId]) -> set[BodyId]:
    """All that touches these bricks, directly or through others, or the nearest of them."""

    def onwards(brick: BodyId) -> list[BodyId]:
        bodies = {body for contact in assembly.contacts(brick) for body in (contact.lower, contact.upper)}
        return sorted(body for body in bodies if body in assembly.bricks)

    group = set(bricks)
    front = group
    while front and len(group) < MOST:
        front = {other for brick in front for other in onwards(brick)} - group
        group |= front
    return group
