"""A brick slid into what stands by then."""

from stackdsl.language.bricks import SetBrick
from stackdsl.language.impacts.impact_kind import ImpactKind, impact


@impact("insert", "slide a brick in")
class Insert(SetBrick, ImpactKind):
    """A brick slid into what stands by then."""

    @property
    def slid_in(self) -> SetBrick:
        return self
