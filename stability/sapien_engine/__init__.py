"""PhysX 5 on the CPU, by way of SAPIEN, behind the protocols of `stability.engine`.

Nothing outside of this package knows the engine.
"""
