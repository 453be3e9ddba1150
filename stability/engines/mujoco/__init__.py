"""MuJoCo behind the protocols of `stability.engines.protocol`; nothing outside of this package knows the engine."""
