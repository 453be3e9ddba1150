"""Exact statics of stacked bricks, and extensions that keep a physics engine from moving what is proven to stand.

Statics alone, without an engine::

    from stability import Assembly, Box, Brick, Pose, margins

An extension in your own PyBullet world::

    from stability import ProvenStability, PyBulletBodies

Each public name is loaded when it is first asked for, so that importing the package costs next to nothing and PyBullet
is needed only by those who use it. Lengths are in metres, masses in kilograms, times in seconds, and z points up.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # what type checkers see; at run time `__getattr__` finds the same
    from stability.engines.pybullet import PyBulletBodies
    from stability.engines.pybullet.client_shapes import UnknownShapeWarning
    from stability.exact.proven_stability import ProvenStability
    from stability.friction_law import Friction, Rule
    from stability.model import Brick, Plane, Pose
    from stability.published.stack_stability import StackStability
    from stability.shapes.box import Box
    from stability.shapes.off_centre_box import OffCentreBox
    from stability.shapes.solid_making import prism, solid_of_corners, solid_of_mesh
    from stability.statics.arrays import bricks_in_poses, bricks_of, forces_of, pose_of
    from stability.statics.assembly import Assembly
    from stability.statics.facts import Placed, Stability, Verdict
    from stability.statics.margins.summary import margins
    from stability.statics.outcomes.outcome import outcome

__all__ = [
    "Assembly",
    "Box",
    "Brick",
    "Friction",
    "OffCentreBox",
    "Placed",
    "Plane",
    "Pose",
    "ProvenStability",
    "PyBulletBodies",
    "Rule",
    "Stability",
    "StackStability",
    "UnknownShapeWarning",
    "Verdict",
    "bricks_in_poses",
    "bricks_of",
    "forces_of",
    "margins",
    "outcome",
    "pose_of",
    "prism",
    "solid_of_corners",
    "solid_of_mesh",
]

_HOMES = {
    "pose_of": "stability.statics.arrays",
    "forces_of": "stability.statics.arrays",
    "bricks_of": "stability.statics.arrays",
    "bricks_in_poses": "stability.statics.arrays",
    "Rule": "stability.friction_law",
    "Friction": "stability.friction_law",
    "Assembly": "stability.statics.assembly",
    "Box": "stability.shapes.box",
    "Brick": "stability.model",
    "OffCentreBox": "stability.shapes.off_centre_box",
    "Placed": "stability.statics.facts",
    "Plane": "stability.model",
    "Pose": "stability.model",
    "ProvenStability": "stability.exact.proven_stability",
    "PyBulletBodies": "stability.engines.pybullet",
    "StackStability": "stability.published.stack_stability",
    "UnknownShapeWarning": "stability.engines.pybullet.client_shapes",
    "Stability": "stability.statics.facts",
    "Verdict": "stability.statics.facts",
    "margins": "stability.statics.margins.summary",
    "outcome": "stability.statics.outcomes.outcome",
    "prism": "stability.shapes.solid_making",
    "solid_of_corners": "stability.shapes.solid_making",
    "solid_of_mesh": "stability.shapes.solid_making",
}


if not TYPE_CHECKING:  # type checkers would take any name for one that it knows

    def __getattr__(name: str) -> object:
        """Load a public name from the module where it lives; Python asks here only the first time."""
        if name not in _HOMES:
            raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
        value = getattr(import_module(_HOMES[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
