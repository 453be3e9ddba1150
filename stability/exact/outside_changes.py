"""What somebody else has done to the frozen bricks of an engine, judged again."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from stability.model import AT_REST, BodyId, BodyState, Plane, Pose
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed, Verdict


@dataclass(frozen=True, slots=True)
class Site:
    """What never moves."""

    planes: Sequence[Plane]
    tables: Sequence[Placed]


@dataclass(frozen=True, slots=True)
class Changed:
    """An assembly after the changes."""

    assembly: Assembly  # another one where what is fixed has changed
    verdict: Verdict | None  # None if nothing has changed
    pushed: Mapping[BodyId, Pose]  # bricks that move, and are no part of it any more


def changed(assembly: Assembly, lost: Collection[BodyId], disturbed: Mapping[BodyId, BodyState], site: Site) -> Changed:
    """Take out what is lost or pushed, move what was moved, and build on what is fixed by now."""
    pushed = {brick: state.pose for brick, state in disturbed.items() if _moves(state)}
    verdict = assembly.remove([*lost, *pushed]) if lost or pushed else None
    for brick, state in disturbed.items():
        if brick not in pushed:
            verdict = assembly.move(brick, state.pose)
    if (tuple(site.planes), tuple(site.tables)) != (assembly.planes, assembly.tables):
        standing = tuple(assembly.bricks.values())
        assembly = Assembly(site.planes, assembly.friction, assembly.gravity, tables=site.tables)
        verdict = assembly.add_all(standing)
    return Changed(assembly, verdict, pushed)


def _moves(state: BodyState) -> bool:
    return state.velocity_W != AT_REST or state.angular_velocity_W != AT_REST
