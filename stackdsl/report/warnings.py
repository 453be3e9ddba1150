"""Warnings of a run: wrong normals, friction errors, modified scenes, tunnelling."""

from collections.abc import Iterable, Iterator, Mapping
from math import degrees

from stability.engines.protocol import WrongFriction
from stackdsl.results import ClaimOutcome, VariantResult
from stackdsl.trace import Collapse, Ensemble, PassedThrough, WrongEdges
from stackdsl.wording import how_many, mm

# Warnings about contacts with a wrong normal in the engine.


def wrong_edges_text(wrong: WrongEdges, collapse: Collapse | None) -> str:
    """Return the number of wrong normals, the worst one, its time and error, and the doubtful results."""
    worst = f"{wrong.upper} on {wrong.lower}, wrong by {degrees(wrong.angle):.0f} deg at {wrong.time:.1f} s"
    contacts = f"1 contact ({worst})" if wrong.contacts == 1 else f"{wrong.contacts} contacts (worst: {worst})"
    return f"wrong edge normals in {contacts}; {_doubt(wrong, collapse)}"


def wrong_edges(results: Iterable[VariantResult]) -> Iterator[str]:
    """Yield a line for each run with wrong normals."""
    for result in results:
        if result.wrong_edges is not None:
            yield f"{result.name}: {wrong_edges_text(result.wrong_edges, result.collapse)}"


def _doubt(wrong: WrongEdges, collapse: Collapse | None) -> str:
    """Return the doubtful results; an error seen only after a collapse cannot have caused it."""
    if collapse is not None and wrong.first > collapse.time:
        return "the final place of this debris cannot be trusted"
    return "the verdict on these bricks cannot be trusted unless it is proven"


# Warnings about friction that the engine cannot represent.


def wrong_friction_text(wrong: WrongFriction) -> str:
    """Return the pair, the error of friction, its time, and the doubtful results."""
    bodies = f"{wrong.first} and {wrong.second}"
    pair = f"{bodies} had {wrong.actual:.3g} instead of {wrong.requested:.3g} at {wrong.time:.1f} s"
    reason = "the engine has one coefficient per body, which cannot match all contacts"
    return f"{reason}: {pair}; proofs are not affected"


def wrong_frictions(results: Iterable[VariantResult]) -> Iterator[str]:
    """Yield a line for each run with a wrong friction."""
    for result in results:
        if result.wrong_friction is not None:
            yield f"{result.name}: {wrong_friction_text(result.wrong_friction)}"


# Notes on scenes that were played with other constants than those of the file.


def modified_text(modified: str) -> str:
    """Return the changed constants, and the scene that the result describes."""
    return f"played with {modified}, so the result is that of a changed scene; lengths refer to the original"


# Outcomes of samples in a few words.


def ensemble_lines(ensemble: Ensemble) -> Iterator[str]:
    """Yield the outcomes of samples, their evidence and cost."""
    parts = [f"{ensemble.stood} stand"]
    if ensemble.fell:
        parts.append(f"{sum(ensemble.fell.values())} fall{levels_told(ensemble.fell)}")
    if ensemble.undecided:
        parts.append(f"{ensemble.undecided} undecided")
    if ensemble.unfit:
        parts.append(f"{ensemble.unfit} without free space for a brick")
    yield f"{ensemble.drawn} of {ensemble.planned} samples drawn, seed {ensemble.seed}: {', '.join(parts)}"
    ways = ", ".join(f"{count} {way}" for way, count in sorted(ensemble.ways.items(), key=lambda each: -each[1]))
    cost = f"{ensemble.cpu_time:.2f} s of CPU time, {1000.0 * ensemble.cpu_time / ensemble.drawn:.3g} ms per sample"
    yield f"decided: {ways}; {cost}"


def samples_told(results: Iterable[VariantResult]) -> Iterator[str]:
    """Yield a line for each result of samples."""
    for result in results:
        if result.ensemble is not None:
            yield f"{result.name}: {'; '.join(ensemble_lines(result.ensemble))}"


def levels_told(fell: Mapping[int, int]) -> str:
    """Return the levels of the falls, and their median."""
    low, high = min(fell), max(fell)
    if low == high:
        return f" at level {low}"
    total, seen = sum(fell.values()), 0
    for level in sorted(fell):
        seen += fell[level]
        if 2 * seen >= total:
            return f" at levels {low} to {high} (median {level})"
    raise AssertionError("half of them fell by the last level")


# Warnings about thrown bricks that passed through others.


def passed_text(passed: PassedThrough) -> str:
    """Return both bricks of a tunnelling, its cause, and the doubtful results."""
    seen = (
        f"{passed.brick} passed through {passed.through} before {passed.time:.3f} s, "
        f"moving {mm(passed.travel)} between two observations"
    )
    why = "the time step of the engine is too long for that speed"
    return f"{seen}: {why}, so the effect of the hit cannot be trusted; throw it more slowly, or use `exact`"


def passed_through(results: Iterable[VariantResult]) -> Iterator[str]:
    """Yield a line for each run with tunnelling."""
    for result in results:
        if result.passed_through is not None:
            yield f"{result.name}: {passed_text(result.passed_through)}"


# Notes on claims that a small disturbance may change.


NEARBY = "play nearby values with `matrix` and allow the range of their results: docs/language.md, Unclear bricks"


def unclear_claims(results: Iterable[VariantResult]) -> Iterator[str]:
    """Yield a line for each claim that is met, but rests on bricks whose fate is unclear."""
    for result in results:
        for outcome in result.outcomes:
            if outcome.passed and outcome.unclear:
                yield f"{outcome.span}: {result.name}: {unclear_text(outcome)}; {NEARBY}"


def unclear_text(outcome: ClaimOutcome) -> str:
    """Return that a claim rests on bricks whose fate is unclear."""
    bricks = f"{how_many(outcome.unclear, 'brick')} whose fate is unclear"
    return f"`{outcome.name}` rests on {bricks}: a tiny change of the scene may change which bricks fall"
