"""Counts what takes long and no time step shows, so that whoever plays a run can bound it.

The counts are those of this process since it began, and only grow: a run is the difference of two looks at them. They
are the same on every machine.
"""

from dataclasses import dataclass


@dataclass
class WorkCount:
    """So much has been done in this process."""

    landings: int = 0  # bricks that were taken into the proof that what drops stops where it lands


COUNT = WorkCount()
