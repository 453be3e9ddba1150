"""What is told of a scenario that fails nothing."""


class OtherEngineWarning(UserWarning):
    """A golden file was made with another engine than this run, so that not all of it could be compared."""


class UncheckedWarning(UserWarning):
    """A structure fell of which nothing is expected, so that its test passes whatever happens."""
