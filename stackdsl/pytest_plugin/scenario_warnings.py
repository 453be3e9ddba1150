"""Warnings about scenarios that do not fail a test."""


class OtherEngineWarning(UserWarning):
    """A golden file was made with another engine than this run, so the comparison was limited."""


class ScenarioWarning(UserWarning):
    """A scenario has an oddity that fails no test, such as a fall without expectations, or a box beyond its deck."""
