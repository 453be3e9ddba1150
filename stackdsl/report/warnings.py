"""Warnings of a run: wrong normals, friction errors, modified scenes, tunnelling."""

from collections.abc import Iterable, Iterator, Mapping
from math import degrees

from stability.engines.protocol import WrongFriction
from stackdsl.results import VariantResult
from stackdsl.trace import Collapse, Ensemble, PassedThrough, WrongEdges
from stackdsl.wording import mm

# What to say of contacts that an engine gave a wrong normal.


def wrong_edges_text(wrong: WrongEdges, collapse: Collapse | None) -> str:
    """Return the number of wrong normals, the worst one, its time and error, and the doubtful results."""
    worst = f"{wrong.upper} on {wrong.lower}, {degrees(wrong.angle):.0f} deg off at {wrong.time:.1f} s"
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
        return "where this debris comes to lie is not to be trusted"
    return "unless proven, whether these bricks stand or fall is not to be trusted"


# What to say of frictions that an engine could not have.


def wrong_friction_text(wrong: WrongFriction) -> str:
    """Return the pair, the error of friction, its time, and the doubtful results."""
    bodies = f"{wrong.first} and {wrong.second}"
    pair = f"{bodies} had {wrong.actual:.3g} in place of {wrong.requested:.3g} at {wrong.time:.1f} s"
    reason = "an engine with one factor a body has none that does for all that touched"
    return f"{reason}: {pair}; what is proven stays so"


def wrong_frictions(results: Iterable[VariantResult]) -> Iterator[str]:
    """Yield a line for each run with a wrong friction."""
    for result in results:
        if result.wrong_friction is not None:
            yield f"{result.name}: {wrong_friction_text(result.wrong_friction)}"


# What to say of a scene that was played with other constants than it is written with.


def modified_text(modified: str) -> str:
    """Return the changed constants, and the scene that the result describes."""
    return f"played with {modified}, so nothing is said of the scene as written; lengths are told as written"


# What became of many samples, in a few words.


def ensemble_lines(ensemble: Ensemble) -> Iterator[str]:
    """Yield the outcomes of samples, their evidence and cost."""
    parts = [f"{ensemble.stood} stand"]
    if ensemble.fell:
        parts.append(f"{sum(ensemble.fell.values())} fall{levels_told(ensemble.fell)}")
    if ensemble.undecided:
        parts.append(f"{ensemble.undecided} undecided")
    if ensemble.unfit:
        parts.append(f"{ensemble.unfit} of which a brick found no place beside others")
    yield f"{ensemble.drawn} of {ensemble.planned} samples drawn, seed {ensemble.seed}: {', '.join(parts)}"
    ways = ", ".join(f"{count} {way}" for way, count in sorted(ensemble.ways.items(), key=lambda each: -each[1]))
    cost = f"{ensemble.cpu_time:.2f} s of all processors, {1000.0 * ensemble.cpu_time / ensemble.drawn:.3g} ms a sample"
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
            return f" at levels {low} to {high}, half of them by level {level}"
    raise AssertionError("half of them fell by the last level")


# What to say of a thrown brick that passed through another one.


def passed_text(passed: PassedThrough) -> str:
    """Return both bricks of a tunnelling, its cause, and the doubtful results."""
    seen = (
        f"{passed.brick} passed through {passed.through} by {passed.time:.3f} s, {mm(passed.travel)} from look to look"
    )
    why = "the engine's steps are too long for that speed"
    return f"{seen}: {why}, and what the hit does is not to be trusted; throw it more slowly, or play it on `exact`"


def passed_through(results: Iterable[VariantResult]) -> Iterator[str]:
    """Yield a line for each run with tunnelling."""
    for result in results:
        if result.passed_through is not None:
            yield f"{result.name}: {passed_text(result.passed_through)}"
