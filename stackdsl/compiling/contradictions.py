"""Can everything that is expected of one system come true? What must stand and what must fall cannot be the same."""

from collections.abc import Iterator, Mapping

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
    for number, claim in enumerate(scenario.expect):
        for before, earlier in enumerate(scenario.expect[:number]):
            shared = [name for name in scenario.systems if _is_of(claim, name) and _is_of(earlier, name)]
            if shared and _exclude(claim.stated, earlier.stated, levels, hold):
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


def _exclude(one: ClaimKind, other: ClaimKind, levels: Mapping[BodyId, int], hold: float) -> bool:
    if type(one) is type(other):
        return one.is_apart_from(other)
    return _takes_away(one, other, levels, hold) or _takes_away(other, one, levels, hold)


def _takes_away(falls: ClaimKind, stands: ClaimKind, levels: Mapping[BodyId, int], hold: float) -> bool:
    """Whether one lets something fall that by the other must stand."""
    groups = list(falls.goes(levels))
    staying = stands.stays(levels, hold) if groups else None
    return staying is not None and any(all(name in staying for name in group) for group in groups)
