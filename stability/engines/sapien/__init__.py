"""PhysX 5 on the CPU, by way of SAPIEN, behind the protocols of `stability.engines.protocol`.

Nothing outside of this package knows the engine.
"""
