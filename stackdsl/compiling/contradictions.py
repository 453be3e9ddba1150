"""Can everything that is expected of one system come true? What must stand and what must fall cannot be the same."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

from stability.model import BodyId
from stackdsl.compiling.asked import asked_of
from stackdsl.compiling.built import Built
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.claims.claim import Expectation
from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.schema import Scenario
from stackdsl.reading.source import Source


def contradictions(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Expectations that cannot hold together with an earlier one."""
    levels, hold = {brick.name: brick.level for brick in built.bricks}, asked_of(scenario).hold
    places = {name: number for number, name in enumerate(levels)}
    meant = [_Meant.of(claim, levels, places, hold) for claim in scenario.expect]
    for number, claim in enumerate(scenario.expect):
        for before, earlier in enumerate(scenario.expect[:number]):
            if not meant[number].excludes(meant[before]):
                continue
            shared = [name for name in scenario.systems if _is_of(claim, name) and _is_of(earlier, name)]
            if shared:
                there = source.key_span_of(("expect", before, earlier.kind))
                here = source.key_span_of(("expect", number, claim.kind))
                which = f"`{earlier.kind}` at {there.seen_from(here)}"
                message = f"this and {which} cannot both hold on {', '.join(shared)}"
                yield Diagnostic("SD104", here, message, "remove one, or say by `system:` what each is expected of")
                break


def beyond_what_is_built(built: Built, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Claims of more levels, or of more bricks, than there ever are: they would fail, or hold, whatever happens."""
    built_of = {"bricks": len(built.bricks), "levels": built.levels}
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            for count in claim.stated.counts():
                most = built_of[count.what]
                if count.least > most:
                    message = f"{count.least:g} {count.what} are claimed, and {most} are built"
                    span = source.span_of((key, number, claim.kind, count.key))
                    yield Diagnostic("SD205", span, message, f"claim at most {most}, or build more")


def _is_of(claim: Expectation, system: str) -> bool:
    return claim.system is None or system in claim.system


@dataclass(frozen=True, slots=True)
class _Meant:
    """One claim with what its bricks do by it, worked out once: it is held against every other claim.

    Sets of bricks are numbers with a bit a brick: a thousand claims on ten thousand bricks are not to fill the memory.
    """

    stated: ClaimKind
    alone: int  # bricks each of which is to fall
    together: Sequence[int]  # groups of bricks, of each of which at least one is to fall
    staying: int | None  # bricks that stand; None if it says of none

    @classmethod
    def of(cls, claim: Expectation, levels: Mapping[BodyId, int], places: Mapping[BodyId, int], hold: float) -> Self:
        """What is written under the key of a claim; `places` numbers the bricks."""
        stated, alone, together = claim.stated, set[BodyId](), list[int]()
        for group in stated.goes(levels):
            if len(group) == 1:
                alone.update(group)
            else:
                together.append(_bits(group, places))
        staying = stated.stays(levels, hold)
        return cls(stated, _bits(alone, places), together, None if staying is None else _bits(staying, places))

    def excludes(self, other: "_Meant") -> bool:
        """Whether both cannot hold."""
        if type(self.stated) is type(other.stated):
            return self.stated.is_apart_from(other.stated)
        return self._takes_away_from(other) or other._takes_away_from(self)

    def _takes_away_from(self, stands: "_Meant") -> bool:
        """Whether this lets something fall that by the other must stand."""
        staying = stands.staying
        if staying is None:
            return False
        return bool(self.alone & staying) or any(group & staying == group for group in self.together)


def _bits(bricks: Collection[BodyId], places: Mapping[BodyId, int]) -> int:
    """A number with a bit for each of some bricks."""
    found = bytearray(len(places) // 8 + 1)
    for brick in bricks:
        place = places[brick]
        found[place >> 3] |= 1 << (place & 7)
    return int.from_bytes(found, "little")
