"""Warnings of scenarios, which do not fail a test."""

ENGINE_INDEPENDENT = "golden file of another engine, compared only in results that do not depend on the engine"


class OtherEngineWarning(UserWarning):
    """A golden file was made with another engine than this run, so only a part of it can be compared."""


class ScenarioWarning(UserWarning):
    """A remarkable result that fails no claim, such as a fall without expectations, or a box beyond its deck."""
