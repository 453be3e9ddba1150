"""What is told of a scenario that fails nothing."""


class OtherEngineWarning(UserWarning):
    """A golden file was made with another engine than this run, so that not all of it could be compared."""


class ScenarioWarning(UserWarning):
    """Something is odd that fails nothing, such as a fall of which nothing is expected, or a box beyond its deck."""
