"""Base class and registry of claims.

A kind of claim is a class in a module of this package. It is read from YAML, declares what it needs from a run, and
judges a trace. The bricks that it names follow from the types of its values (`BodyName` and others).
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
from stackdsl.timeline import AccelerationTest
from stackdsl.trace import Trace


@dataclass(frozen=True, slots=True)
class Count:
    """The least number of bricks or levels that a claim needs."""

    key: str  # of the claim
    least: float
    noun: Literal["bricks", "levels"]


@dataclass(frozen=True, slots=True)
class ImpliedOutcome:
    """The outcome of the whole structure that a claim implies."""

    stands: bool
    level: Tolerance | None = None  # under construction when it falls
    time: Tolerance | None = None  # when it falls [s]
    seen: bool = False  # the claim is about the collapse itself, and outweighs claims that only imply an outcome


class ClaimKind(ABC):
    """One statement about the outcome of a run. Kinds override the defaults here."""

    needs_statics: ClassVar[bool] = False  # needs a system with proofs
    needs_dense_recording: ClassVar[bool] = False  # needs dense recording of the onset of a fall and of its landing
    reported_margins: ClassVar[tuple[str, ...]] = ()  # of the proof, for few bricks; no claim needs them
    needed_measures: ClassVar[tuple[str, ...]] = ()  # measurements that take time, such as `sway`
    requires_physical_collapse: ClassVar[bool] = False  # void if the collapse is an artefact of the solver
    measures_engine: ClassVar[bool] = False  # measures the quality of the engine, so its faults do not void the claim
    allows_removed_bricks: ClassVar[bool] = False  # may name bricks that are pulled out
    only_falls: ClassVar[bool] = False  # depends on which bricks fall or stand, but not on their places
    identifying_keys: ClassVar[tuple[str, ...]] = ()  # equal in two claims of this kind about the same quantity

    @abstractmethod
    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the claim with a trace."""

    def is_decided(self, trace: Trace) -> bool:
        """Return whether the result can no longer change, in a run that has collapsed or is over.

        Building is over by then. Fallen bricks stay fallen, moving bricks may fall, and remaining actions may bring
        down any other brick. Bricks that are still to be pulled out count as removed (`Trace.pending_removals`).
        """
        return False

    @property
    def final_once_watched(self) -> bool:
        """Return whether the claim is about the watched time only, so that later motion does not change it."""
        return False

    @property
    def needed_margins(self) -> Collection[str]:
        """Return the margins of the proof that the claim needs, such as `tilt`."""
        return ()

    @property
    def needed_tests(self) -> Collection[AccelerationTest]:
        """Return the tests of the finished structure that the claim needs."""
        return ()

    @property
    def needed_hold(self) -> float | None:
        """Return the time for which the structure must be watched after the last action [s]; None for any time."""
        return None

    @property
    def wanted_share(self) -> Tolerance | None:
        """Return the share of samples in which the claim must hold; None for a claim about one run."""
        return None

    def holds_for_sample(self, fell_at: int | None) -> bool:
        """Return whether the claim holds for a sample that fell at a level, or stands. Only for kinds with a share."""
        raise NotImplementedError

    def counts(self) -> Iterator[Count]:
        """Yield the numbers of bricks or levels without which the result does not depend on the run."""
        return iter(())

    def must_stand(self, levels: Mapping[BodyId, int], hold: float) -> Collection[BodyId] | None:
        """Return the bricks that must stand to the end; None if the claim requires no brick to stand.

        `levels` has the level of each brick; `hold` is the time for which the structure is watched after the last
        action [s].
        """
        return None

    def must_fall(self, levels: Mapping[BodyId, int]) -> Iterable[Collection[BodyId]]:
        """Return groups of bricks, of each of which at least one must fall. `levels` has the level of each brick."""
        return ()

    def rests_on_fate_of(self, trace: Trace) -> Collection[BodyId]:
        """Return the bricks whose fall decides the claim one by one, such as those that it counts."""
        return ()

    def expects_fall_of(self, bricks: Collection[BodyId]) -> bool:
        """Return whether the claim expects these bricks to fall at any time, so also before an impact on them."""
        return self.implied_outcome is not None and not self.implied_outcome.stands

    def contradicts(self, other: Self) -> bool:
        """Return whether two claims of this kind contradict each other: no value of the same quantity meets both."""
        if not isinstance(self, AuthorModel) or any(
            getattr(self, key) != getattr(other, key) for key in self.identifying_keys
        ):
            return False
        if self.wanted_share is not None and other.wanted_share is not None:  # of the same samples
            alike = all(getattr(self, key) == getattr(other, key) for key in type(self).model_fields if key != "share")
            return alike and not self.wanted_share.meets(other.wanted_share)
        pairs = [
            (getattr(self, key), getattr(other, key))
            for key in type(self).model_fields
            if key not in self.identifying_keys
        ]
        return any(isinstance(a, Tolerance) and isinstance(b, Tolerance) and not a.meets(b) for a, b in pairs)

    @property
    def implied_outcome(self) -> ImpliedOutcome | None:
        """Return the outcome of the whole structure that the claim implies, if any."""
        return None


@dataclass(frozen=True, slots=True)
class KindOfClaim:
    """A registered kind of claim: its model, and its description for editors."""

    model: type[ClaimKind]
    summary: str


CLAIMS: Final = Kinds[KindOfClaim](
    "claim",
    "stands",
    "collapses",
    "leaves",
    "falls",
    "pivots",
    "lands",
    "displaced",
    "drift",
    "rests_on",
    "height",
    "untouched",
    "energy",
    "verdict",
    "margin",
    "protocol",
    "load",
    "pressure",
    "overhang",
    "weight",
    "centre_of_mass",
    "sway",
    "penetration",
)

Model = TypeVar("Model", bound=ClaimKind)


def claim(key: str, summary: str) -> Callable[[type[Model]], type[Model]]:
    """Return a decorator that registers the model of the key `key`. It raises TypeError for an abstract class."""

    def register(model: type[Model]) -> type[Model]:
        if isabstract(model):
            raise TypeError(f"the class of the claim '{key}' does not implement `judge`")
        CLAIMS.register(key, KindOfClaim(model, summary))
        return model

    return register
