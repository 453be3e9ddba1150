"""What is no convex solid, and why."""


class NotASolidError(ValueError):
    """Points, an outline or a mesh that make no convex solid."""

    def __init__(self, message: str, hint: str, number: int | None = None) -> None:
        super().__init__(message)
        self.message, self.hint = message, hint
        self.number = number  # of the corner or the face that is wrong, from 0; None if it is the whole
