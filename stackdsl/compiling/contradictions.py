"""Can everything that is expected of one system come true? What must stand and what must fall cannot be the same."""

from collections.abc import Iterator, Mapping, Sequence
from math import ceil, floor, inf
from typing import Final

from stability.model import BodyId
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.author_models import AuthorModel
from stackdsl.language.claims import Claim, Collapses, Expectation, Stands
from stackdsl.language.schema import Scenario
from stackdsl.language.tolerances import Tolerance
from stackdsl.reading.source import Path, Source

# What has to be the same in two claims of a kind, so that they speak of one and the same thing.
SAME: Final[Mapping[str, Sequence[str]]] = {
    "drift": ("bricks",),
    "height": ("of",),
    "displaced": ("by",),
    "rests_on": ("brick", "support"),
}


def contradictions(
    scenario: Scenario, levels: Mapping[BodyId, int], hold: float, source: Source
) -> Iterator[Diagnostic]:
    """Expectations that cannot hold together with an earlier one.

    `levels` are those of all bricks, `hold` is how long the structure is watched after it is built [s].
    """
    for number, claim in enumerate(scenario.expect):
        for before, earlier in enumerate(scenario.expect[:number]):
            shared = [name for name in scenario.systems if _is_of(claim, name) and _is_of(earlier, name)]
            if shared and _exclude(claim, earlier, levels, hold):
                there = source.key_span_of(("expect", before, earlier.kind))
                which = f"`{earlier.kind}` at {there.line}:{there.column}"
                message = f"this and {which} cannot both hold on {', '.join(shared)}"
                here = source.key_span_of(("expect", number, claim.kind))
                yield Diagnostic("SD104", here, message, "remove one, or say by `system:` what each is expected of")
                break


def beyond_what_is_built(scenario: Scenario, levels: int, bricks: int, source: Source) -> Iterator[Diagnostic]:
    """Claims of more levels, or of more bricks, than there ever are: they would fail, or hold, whatever happens."""
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            for path, claimed in _counted(claim):
                built, what = (bricks, "bricks") if path[-1] in ("bricks", "count") else (levels, "levels")
                if claimed > built:
                    message = f"{claimed:g} {what} are claimed, and {built} are built"
                    span = source.span_of((key, number, *path))
                    yield Diagnostic("SD205", span, message, f"claim at most {built}, or build more")


def _counted(claim: Claim) -> Iterator[tuple[Path, float]]:
    """How many levels or bricks a claim needs at least, with the place where it says so."""
    if claim.stands is not None and claim.stands.levels is not None:
        yield ("stands", "levels"), claim.stands.levels
    if claim.collapses is not None and claim.collapses.at is not None:
        yield ("collapses", "at"), _at_least(claim.collapses.at)
    if claim.untouched is not None and claim.untouched.levels is not None:
        yield ("untouched", "levels"), claim.untouched.levels
    if claim.leaves is not None and claim.leaves.levels is not None:
        yield ("leaves", "levels"), _at_least(claim.leaves.levels)
    if claim.leaves is not None and claim.leaves.bricks is not None:
        yield ("leaves", "bricks"), _at_least(claim.leaves.bricks)
    if claim.falls is not None and claim.falls.count is not None:
        yield ("falls", "count"), _at_least(claim.falls.count)


def _at_least(count: Tolerance) -> float:
    """The least whole number that holds."""
    if count.low == -inf:
        return 0.0
    return floor(count.low) + 1.0 if count.low_open else float(ceil(count.low))


def _is_of(claim: Expectation, system: str) -> bool:
    return claim.system is None or system in claim.system


def _exclude(one: Expectation, other: Expectation, levels: Mapping[BodyId, int], hold: float) -> bool:
    if one.verdict is not None and other.verdict is not None:
        return one.verdict != other.verdict
    if one.kind == other.kind:
        return _are_apart(getattr(one, one.kind), getattr(other, one.kind), SAME.get(one.kind, ()))
    stands, collapses, falls = one.stands or other.stands, one.collapses or other.collapses, one.falls or other.falls
    if stands is None or (stands.for_ is not None and stands.for_ < hold):
        return False  # what stands for a while may fall after it
    if falls is not None:
        return any(_must_stand(stands, levels[name], name) for name in falls.bricks or () if name in levels)
    return collapses is not None and _leaves_nothing_to_fall(stands, collapses, levels)


def _are_apart(one: object, other: object, same: Sequence[str]) -> bool:
    """Whether two claims of one kind want values of one and the same thing that no value meets."""
    if not isinstance(one, AuthorModel) or any(getattr(one, key) != getattr(other, key) for key in same):
        return False
    pairs = [(getattr(one, key), getattr(other, key)) for key in type(one).model_fields if key not in same]
    return any(isinstance(a, Tolerance) and isinstance(b, Tolerance) and not a.meets(b) for a, b in pairs)


def _leaves_nothing_to_fall(stands: Stands, collapses: Collapses, levels: Mapping[BodyId, int]) -> bool:
    """Whether every brick that may be the first to fall is one of those that must stand."""
    return all(_must_stand(stands, level, name) for name, level in levels.items() if collapses.brick in (None, name))


def _must_stand(stands: Stands, level: int, name: BodyId) -> bool:
    return (stands.levels is None or level <= stands.levels) and (stands.bricks is None or name in stands.bricks)
