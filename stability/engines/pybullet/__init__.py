"""PyBullet behind the protocols of `stability.engines.protocol`; nothing outside of this package knows the engine.

`PyBulletBodies` attaches to a client that somebody else runs. `PyBulletWorld` runs one of its own.
"""

from stability.engines.pybullet.client import PyBulletBodies
from stability.engines.pybullet.pybullet_world import PyBulletWorld

__all__ = ["PyBulletBodies", "PyBulletWorld"]
