"""What a kind of claim answers for itself, and all the kinds there are.

A kind is one module beside this one: a class that is read from YAML, says what it needs and what it rules out, and
judges a trace. What it names is known from the types of its values (`BodyName` and the like).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from inspect import isabstract
from typing import ClassVar, Final, Literal, Self, TypeVar

from stability.model import BodyId
from stackdsl.language.claims.claim_result import ClaimResult
from stackdsl.language.model_base import AuthorModel, Kinds
from stackdsl.language.tolerances import Tolerance
from stackdsl.trace import Trace


@dataclass(frozen=True, slots=True)
class Count:
    """So many bricks or levels that a claim needs at least, under one of its keys."""

    key: str
    least: float
    what: Literal["bricks", "levels"]


@dataclass(frozen=True, slots=True)
class ImpliedOutcome:
    """What becomes of the structure as a whole, as far as a claim says so."""

    stands: bool
    level: Tolerance | None = None  # under construction when it falls
    time: Tolerance | None = None  # when it falls [s]
    seen: bool = False  # as it happens, which outweighs what is said to stand beside it


class ClaimKind(ABC):
    """One statement about what happened. A kind that says nothing else answers as it stands here."""

    needs_statics: ClassVar[bool] = False  # only a system with proofs can tell
    needs_close_looks: ClassVar[bool] = False  # how something begins to fall, or where it lands
    told_margins: ClassVar[tuple[str, ...]] = ()  # of the proof, that it tells of few bricks without depending on them
    needed_measures: ClassVar[tuple[str, ...]] = ()  # what takes time to measure, such as `sway`
    requires_physical_collapse: ClassVar[bool] = False  # void where the only collapse is the solver's
    of_the_engine: ClassVar[bool] = False  # measures how well an engine plays, so that its faults do not void it
    allows_removed_bricks: ClassVar[bool] = False  # may speak of bricks that are pulled out
    same: ClassVar[tuple[str, ...]] = ()  # keys that two of a kind share if they speak of one and the same thing

    @abstractmethod
    def judge(self, trace: Trace) -> ClaimResult:
        """What the claim comes to, held against what happened."""

    def is_decided(self, trace: Trace) -> bool:
        """Whether it comes to the same whatever else happens, of a run that has collapsed, or is over.

        Nothing is built any more. What has fallen has fallen, what moves may fall, and what is still to be done may
        bring anything else down; what is to be pulled out counts as gone (`Trace.gone`).
        """
        return False

    @property
    def final_once_watched(self) -> bool:
        """Whether it speaks of what was seen as long as it was watched, so that nothing that follows changes it."""
        return False

    @property
    def needed_margins(self) -> Collection[str]:
        """The margins of the proof that it asks for, such as `tilt`."""
        return ()

    @property
    def needed_hold(self) -> float | None:
        """How long the structure must be watched after the last action; None if that is all one to it [s]."""
        return None

    @property
    def wanted_share(self) -> Tolerance | None:
        """The share of samples in which it is to hold; None if it speaks of one run."""
        return None

    def holds_of(self, fell_at: int | None) -> bool:
        """Whether it holds of a sample that fell at this level, or stands: for kinds that want a share."""
        raise NotImplementedError

    def counts(self) -> Iterator[Count]:
        """How many bricks or levels there must be, or else it fails, or holds, whatever happens."""
        return iter(())

    def must_stand(self, levels: Mapping[BodyId, int], hold: float) -> Collection[BodyId] | None:
        """The bricks that must stand to the end, of all by level; None if it says of none that they must.

        `hold` is how long the structure is watched after the last action [s].
        """
        return None

    def must_fall(self, levels: Mapping[BodyId, int]) -> Iterable[Collection[BodyId]]:
        """Groups of bricks, of all by level, of each of which at least one must fall."""
        return ()

    def expects_fall_of(self, bricks: Collection[BodyId]) -> bool:
        """Whether it says that these fall, whenever it is: then they may do so before anything is done to them."""
        return self.fate is not None and not self.fate.stands

    def is_apart_from(self, other: Self) -> bool:
        """Whether two of this kind want values of one and the same thing that no value meets."""
        if not isinstance(self, AuthorModel) or any(getattr(self, key) != getattr(other, key) for key in self.same):
            return False
        if self.wanted_share is not None and other.wanted_share is not None:  # of the same samples
            alike = all(getattr(self, key) == getattr(other, key) for key in type(self).model_fields if key != "share")
            return alike and not self.wanted_share.meets(other.wanted_share)
        pairs = [(getattr(self, key), getattr(other, key)) for key in type(self).model_fields if key not in self.same]
        return any(isinstance(a, Tolerance) and isinstance(b, Tolerance) and not a.meets(b) for a, b in pairs)

    @property
    def fate(self) -> ImpliedOutcome | None:
        """What it says of the structure as a whole, if it does."""
        return None


@dataclass(frozen=True, slots=True)
class KindOfClaim:
    """A kind, as `Claim` has it: the class that is read, and a phrase for editors."""

    model: type[ClaimKind]
    summary: str


CLAIMS: Final = Kinds[KindOfClaim]("claim")

Model = TypeVar("Model", bound=ClaimKind)


def claim(key: str, summary: str) -> Callable[[type[Model]], type[Model]]:
    """Register the class below as what an author writes under a key. Raises TypeError if it cannot be judged."""

    def register(model: type[Model]) -> type[Model]:
        if isabstract(model):
            raise TypeError(f"the claim '{key}' does not say how it is judged")
        CLAIMS.register(key, KindOfClaim(model, summary))
        return model

    return register
