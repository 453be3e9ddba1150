"""Exact statics of stacked bricks, and stabilizers for physics engines, which freeze bricks that provably stand.

Statics alone, without an engine::

    from stability import Assembly, Box, Brick, Pose, margins

A stabilizer in your own PyBullet world::

    from stability import ProvenStability, PyBulletBodies

Public names are loaded at their first use, so that importing the package is fast and PyBullet is optional. Lengths are
in metres, masses in kilograms, times in seconds, and z points up.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # for type checkers; at run time `__getattr__` loads the same names
    from stability.analysis.load_bounds import loads_between, loads_on
    from stability.analysis.load_factor import load_factor
    from stability.analysis.margins import margins
    from stability.analysis.uniqueness import outcome
    from stability.contact_law import Friction, Rule
    from stability.engines.pybullet import PyBulletBodies
    from stability.engines.pybullet.client import UnknownShapeWarning
    from stability.geometry.box import Box, OffCentreBox
    from stability.geometry.solid_making import prism, solid_of_corners, solid_of_mesh
    from stability.joints import Bond, JointRule, Joints, Pull, Studs
    from stability.loads import Load, Loads
    from stability.model import Brick, Plane, Pose
    from stability.problem import Placed, Stability, Verdict
    from stability.stabilizers.exact.stabilizer import ProvenStability
    from stability.stabilizers.published.stabilizer import StackStability
    from stability.statics.arrays import bricks_in_poses, bricks_of, forces_of, pose_of
    from stability.statics.assembly import Assembly
    from stability.statics.used_strength import used_strength
    from stability.strength import Strength

__all__ = [
    "Assembly",
    "Bond",
    "Box",
    "Brick",
    "Friction",
    "JointRule",
    "Joints",
    "Load",
    "Loads",
    "OffCentreBox",
    "Placed",
    "Plane",
    "Pose",
    "ProvenStability",
    "Pull",
    "PyBulletBodies",
    "Rule",
    "Stability",
    "StackStability",
    "Strength",
    "Studs",
    "UnknownShapeWarning",
    "Verdict",
    "bricks_in_poses",
    "bricks_of",
    "forces_of",
    "load_factor",
    "loads_between",
    "loads_on",
    "margins",
    "outcome",
    "pose_of",
    "prism",
    "solid_of_corners",
    "solid_of_mesh",
    "used_strength",
]

_HOMES = {
    "pose_of": "stability.statics.arrays",
    "forces_of": "stability.statics.arrays",
    "bricks_of": "stability.statics.arrays",
    "bricks_in_poses": "stability.statics.arrays",
    "Rule": "stability.contact_law",
    "Friction": "stability.contact_law",
    "Assembly": "stability.statics.assembly",
    "Bond": "stability.joints",
    "JointRule": "stability.joints",
    "Joints": "stability.joints",
    "Pull": "stability.joints",
    "Studs": "stability.joints",
    "Load": "stability.loads",
    "Loads": "stability.loads",
    "load_factor": "stability.analysis.load_factor",
    "loads_between": "stability.analysis.load_bounds",
    "loads_on": "stability.analysis.load_bounds",
    "Box": "stability.geometry.box",
    "Brick": "stability.model",
    "OffCentreBox": "stability.geometry.box",
    "Placed": "stability.problem",
    "Plane": "stability.model",
    "Pose": "stability.model",
    "ProvenStability": "stability.stabilizers.exact.stabilizer",
    "PyBulletBodies": "stability.engines.pybullet",
    "StackStability": "stability.stabilizers.published.stabilizer",
    "UnknownShapeWarning": "stability.engines.pybullet.client",
    "Stability": "stability.problem",
    "Verdict": "stability.problem",
    "margins": "stability.analysis.margins",
    "outcome": "stability.analysis.uniqueness",
    "Strength": "stability.strength",
    "used_strength": "stability.statics.used_strength",
    "prism": "stability.geometry.solid_making",
    "solid_of_corners": "stability.geometry.solid_making",
    "solid_of_mesh": "stability.geometry.solid_making",
}


if not TYPE_CHECKING:  # with `__getattr__`, type checkers would accept any name

    def __getattr__(name: str) -> object:
        """Load a public name from its module at its first use."""
        if name not in _HOMES:
            raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
        value = getattr(import_module(_HOMES[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
