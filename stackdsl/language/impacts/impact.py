"""One thing that is done to a structure, while it is built or after."""

from typing import cast

from pydantic import Field

from stackdsl.language.anchors import Timed
from stackdsl.language.author_types import PositiveDuration
from stackdsl.language.impacts.impact_kind import ImpactKind


class Impact(Timed):
    """One thing done to the structure. Another kind is another key here, and another action of the timeline."""

    every: PositiveDuration | None = Field(
        None, description="from one repetition to the next; default: all at one time"
    )

    @property
    def done(self) -> ImpactKind:
        """What is written under its key."""
        return cast("ImpactKind", getattr(self, self.kind))
