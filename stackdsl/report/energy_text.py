"""What to say of energy that an engine added by itself."""


def energy_text(gained: float) -> str:
    """How much it was, and what that leaves in doubt."""
    return (
        f"the engine added {100.0 * gained:.3g} % to the energy that there was; how bricks moved is not to be trusted"
    )
