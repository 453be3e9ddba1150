"""MuJoCo behind the protocols of `stability.engines.protocol`; no code outside this package uses the engine."""
