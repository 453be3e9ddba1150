"""What a kind of impact answers for itself, and all the kinds there are.

A kind is one module beside this one, a class that is read from YAML, and one in `compiling/impacts`, which says what it
comes to in the scene. What it names is known from the types of its values (`BodyName` and the like).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final, TypeVar

from stability.model import BodyId
from stackdsl.language.author_models import AuthorModel
from stackdsl.language.bricks import BrickKind, SetBrick
from stackdsl.language.kinds import Kinds
from stackdsl.language.named import Named


@dataclass(frozen=True, slots=True)
class Missile:
    """A brick that comes from outside, and is no part of the structure."""

    name: BodyId | None  # None for such as `thrown-1`
    brick: BrickKind | None  # None for the scenario's
    how: str  # it comes: `thrown`


class ImpactKind(AuthorModel):
    """One thing done to the structure. A kind that says nothing else answers as it stands here."""

    @property
    def slid_in(self) -> SetBrick | None:
        """The brick that becomes part of the structure."""
        return None

    @property
    def missile(self) -> Missile | None:
        """The brick that comes from outside."""
        return None

    @property
    def pulled_out(self) -> Iterable[Named]:
        """The bricks that are taken away."""
        return ()

    @property
    def lasts(self) -> float:
        """How long it goes on, so that what comes after it has to wait [s]."""
        return 0.0

    @property
    def struck(self) -> Iterable[BodyId]:
        """The bricks whose own way ends with it, so that from then on only a run can tell where they are."""
        return ()


@dataclass(frozen=True, slots=True)
class KindOfImpact:
    """A kind, as `Impact` has it: the class that is read, and a phrase for editors."""

    model: type[ImpactKind]
    summary: str


IMPACTS: Final = Kinds[KindOfImpact]("impact")

Model = TypeVar("Model", bound=ImpactKind)


def impact(key: str, summary: str) -> Callable[[type[Model]], type[Model]]:
    """Register the class below as what an author writes under a key."""

    def register(model: type[Model]) -> type[Model]:
        IMPACTS.register(key, KindOfImpact(model, summary))
        return model

    return register
