"""What is told of a golden file that another engine made."""


class OtherEngineWarning(UserWarning):
    """A golden file was made with another engine than this run, so that not all of it could be compared."""
