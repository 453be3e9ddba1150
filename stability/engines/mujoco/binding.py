"""The only module that imports mujoco."""

import mujoco

__all__ = ["mujoco"]


def _silent(message: str) -> None:
    """Suppress the log file that MuJoCo writes into the working directory; worlds count the warnings instead."""


mujoco.set_mju_user_warning(_silent)
