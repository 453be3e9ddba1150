"""The one file that imports mujoco; the rest of the package has it from here."""

import mujoco

__all__ = ["mujoco"]


def _silent(message: str) -> None:
    """By default a warning goes into a file beside whatever its user is working on. Worlds count them instead."""


mujoco.set_mju_user_warning(_silent)
