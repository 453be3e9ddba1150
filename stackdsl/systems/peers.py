"""Systems on other engines, to compare with: each exists where its package is installed.

Only the command line and benchmarks know them. A scenario cannot name them in `systems`, so that it is right or wrong
alike for those who have the package and those who have not (docs/decisions/0016).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec

from stability.engines.mujoco.mujoco_settings import MuJoCoSettings
from stability.engines.sapien.sapien_settings import SapienSettings
from stackdsl.systems.systems import MOVING, SYSTEMS, Method, System


@dataclass(frozen=True, slots=True)
class Extra:
    """A package that not everybody has."""

    package: str  # what is imported
    name: str  # the extra of stackdsl that brings it

    @property
    def installed(self) -> bool:
        """Whether the package is there; it is not imported."""
        return find_spec(self.package) is not None


@dataclass(frozen=True, slots=True)
class Peer:
    """A system, and what it needs."""

    system: System
    extra: Extra


WITH_MUJOCO, WITH_SAPIEN = Extra("mujoco", "mujoco"), Extra("sapien", "sapien")


# What stacked best at real constants: stiffer springs and finer steps cost more and help no longer.
MUJOCO = MuJoCoSettings(
    time_step=0.001,
    iterations=100,
    contact_time=0.004,
    impedance_range=(0.95, 0.99, 0.0005),
    friction_impedance=10.0,
    tolerance=1e-8,
    most_travel=MOVING.most_travel,
)

# Five times the cost, for straight columns of a hundred planks.
MUJOCO_STIFF = MuJoCoSettings(
    time_step=0.0005,
    iterations=200,
    contact_time=0.0012,
    impedance_range=(0.98, 0.999, 0.0001),
    friction_impedance=10.0,
    tolerance=1e-10,
    most_travel=MOVING.most_travel,
)

SAPIEN = SapienSettings(
    time_step=1.0 / 960.0,
    iterations=20,
    velocity_iterations=1,
    contact_offset=0.001,
    most_travel=MOVING.most_travel,
)

PEERS = {
    peer.system.name: peer
    for peer in (
        Peer(System("mujoco", "MuJoCo with the settings that stack best", MUJOCO, method=None), WITH_MUJOCO),
        Peer(System("mujoco-stiff", "MuJoCo with stiff contacts", MUJOCO_STIFF, method=None), WITH_MUJOCO),
        Peer(System("mujoco-exact", "exact statics, and MuJoCo for what moves", MUJOCO, Method.PROVEN), WITH_MUJOCO),
        Peer(System("sapien", "PhysX 5 with the settings that stack best", SAPIEN, method=None), WITH_SAPIEN),
    )
}
NEEDS: Mapping[str, Extra] = {name: peer.extra for name, peer in PEERS.items()}


def system_named(name: str) -> System:
    """A system, or one on another engine."""
    return PEERS[name].system if name in PEERS else SYSTEMS[name]


def missing(names: Iterable[str], needs: Mapping[str, Extra] = NEEDS) -> list[tuple[str, Extra]]:
    """Those of some systems that need what is not installed, and what that is."""
    return [(name, needs[name]) for name in names if name in needs and not needs[name].installed]
