"""What to say of a scene that was played with other constants than it is written with."""


def modified_text(modified: str) -> str:
    """What they are, and of what the result tells."""
    return f"played with {modified}, so nothing is said of the scene as written; lengths are told as written"
