"""MuJoCo behind the protocols of `stability.engine`; nothing outside of this package knows the engine."""
