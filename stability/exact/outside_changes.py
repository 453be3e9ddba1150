"""Judges the frozen bricks again after somebody else has moved, pushed or taken some, or changed what is fixed."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import inf

from stability.model import AT_REST, BodyId, BodyState, Plane, Pose
from stability.statics.assembly import Assembly
from stability.statics.facts import Placed, Verdict


@dataclass(frozen=True, slots=True)
class Site:
    """The fixed bodies of a world."""

    planes: Sequence[Plane]
    tables: Sequence[Placed]


@dataclass(frozen=True, slots=True)
class Changed:
    """An assembly after such changes."""

    assembly: Assembly  # a new one if the fixed bodies have changed
    verdict: Verdict | None  # None if nothing has changed
    pushed: Mapping[BodyId, Pose]  # bricks that move, and so are no longer part of the assembly


def changed(assembly: Assembly, lost: Collection[BodyId], disturbed: Mapping[BodyId, BodyState], site: Site) -> Changed:
    """Remove the bricks that are lost or pushed, move those that were moved, and take in new fixed bodies."""
    pushed = {brick: state.pose for brick, state in disturbed.items() if _moves(state)}
    verdict = assembly.remove([*lost, *pushed]) if lost or pushed else None
    for brick, state in disturbed.items():
        if brick not in pushed:
            verdict = assembly.move(brick, state.pose)
    if (tuple(site.planes), tuple(site.tables)) != (assembly.planes, assembly.tables):
        standing = tuple(assembly.bricks.values())
        assembly = Assembly(
            site.planes, assembly.friction, assembly.gravity, assembly.tolerances, site.tables, overlap=inf
        )
        verdict = assembly.add_all(standing)
    return Changed(assembly, verdict, pushed)


def _moves(state: BodyState) -> bool:
    return state.velocity_W != AT_REST or state.angular_velocity_W != AT_REST
