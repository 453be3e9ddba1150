"""PyBullet behind the protocols of `stability.engine`; nothing outside of this package knows the engine.

`PyBulletBodies` attaches to a client that somebody else runs. `PyBulletWorld` runs one of its own.
"""

from stability.pybullet_engine.bodies import PyBulletBodies
from stability.pybullet_engine.joining import PyBulletWorld

__all__ = ["PyBulletBodies", "PyBulletWorld"]
