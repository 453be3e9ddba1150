"""Which way what falls goes, and how far its weight lies beyond the edge that it tips over."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import atan2, dist, hypot

from stability.model import BodyId
from stability.statics.facts import Motion, Placed, Stability, Stage, Verdict

ALIKE = 1e-6  # share by which spins of one body may differ
SIDEWAYS = 0.05  # of the mean speed: what goes to a side more slowly goes down


@dataclass(frozen=True, slots=True)
class FallSide:
    """Each None where there is none: what drops goes to no side."""

    bearing: float | None = None  # from +x towards +y [rad]
    overhang: float | None = None  # of the common centre of mass beyond the edge, in plan [m]; of what tips as one body


def fall_side(verdict: Verdict, bricks: Mapping[BodyId, Placed]) -> FallSide:
    """The side of a proven fall of some bricks in their places."""
    motion = verdict.motion
    if verdict.stability is not Stability.UNSTABLE or motion is None or not motion.velocity:
        return FallSide()
    as_one = verdict.stage is Stage.TIPPING and _turns_as_one(motion)
    return _over_an_edge(motion, bricks) if as_one else _sideways(motion, bricks)


def _turns_as_one(motion: Motion) -> bool:
    """Whether all have one spin, as they have where they tip over one edge and nothing else begins to move."""
    spins = [spin for _, spin in motion.velocity.values()]
    return all(dist(spin, spins[0]) <= ALIKE * hypot(*spins[0]) for spin in spins)


def _over_an_edge(motion: Motion, bricks: Mapping[BodyId, Placed]) -> FallSide:
    """Of a turn as one body about a level edge: all have one spin, and the centre sinks by the spin times its lever."""
    _, (wx, wy, _) = next(iter(motion.velocity.values()))
    spin = hypot(wx, wy)
    if spin == 0.0:
        return FallSide()
    masses = {name: bricks[name].brick.mass for name in motion.velocity}
    sinking = -sum(mass * motion.velocity[name][0][2] for name, mass in masses.items()) / sum(masses.values())
    return FallSide(atan2(-wx, wy), sinking / spin)


def _sideways(motion: Motion, bricks: Mapping[BodyId, Placed]) -> FallSide:
    """Of any other motion: where its mass goes, if that is to one side."""
    x = y = speed = 0.0
    for name, (velocity, _) in motion.velocity.items():
        mass = bricks[name].brick.mass
        x, y, speed = x + mass * velocity[0], y + mass * velocity[1], speed + mass * hypot(*velocity)
    return FallSide(atan2(y, x)) if hypot(x, y) > SIDEWAYS * speed else FallSide()
