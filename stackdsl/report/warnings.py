"""Warnings of a run: wrong normals, friction errors, modified scenes, tunnelling."""

from collections.abc import Iterable, Iterator, Mapping
from math import degrees

from stability.engines.protocol import WrongFriction
from stackdsl.results import VariantResult
from stackdsl.trace import Collapse, Ensemble, PassedThrough, WrongEdges
from stackdsl.wording import mm

# What to say of contacts that an engine gave a wrong normal.


def wrong_edges_text(wrong: WrongEdges, collapse: Collapse | None) -> str:
    """How many, which one most, when and by how much, and what that leaves in doubt."""
    worst = f"{wrong.upper} on {wrong.lower}, {degrees(wrong.angle):.0f} deg off at {wrong.time:.1f} s"
    contacts = f"1 contact ({worst})" if wrong.contacts == 1 else f"{wrong.contacts} contacts (worst: {worst})"
    return f"wrong edge normals in {contacts}; {_doubt(wrong, collapse)}"


def wrong_edges(results: Iterable[VariantResult]) -> Iterator[str]:
    """A line for each run that had some."""
    for result in results:
        if result.wrong_edges is not None:
            yield f"{result.name}: {wrong_edges_text(result.wrong_edges, result.collapse)}"


def _doubt(wrong: WrongEdges, collapse: Collapse | None) -> str:
    """What was seen only after a collapse cannot have caused it."""
    if collapse is not None and wrong.first > collapse.time:
        return "where this debris comes to lie is not to be trusted"
    return "unless proven, whether these bricks stand or fall is not to be trusted"


# What to say of frictions that an engine could not have.


def wrong_friction_text(wrong: WrongFriction) -> str:
    """Between whom, how far off, when, and what that leaves in doubt."""
    bodies = f"{wrong.first} and {wrong.second}"
    pair = f"{bodies} had {wrong.actual:.3g} in place of {wrong.requested:.3g} at {wrong.time:.1f} s"
    reason = "an engine with one factor a body has none that does for all that touched"
    return f"{reason}: {pair}; what is proven stays so"


def wrong_frictions(results: Iterable[VariantResult]) -> Iterator[str]:
    """A line for each run that had one."""
    for result in results:
        if result.wrong_friction is not None:
            yield f"{result.name}: {wrong_friction_text(result.wrong_friction)}"


# What to say of a scene that was played with other constants than it is written with.


def modified_text(modified: str) -> str:
    """What they are, and of what the result tells."""
    return f"played with {modified}, so nothing is said of the scene as written; lengths are told as written"


# What became of many samples, in a few words.


def ensemble_lines(ensemble: Ensemble) -> Iterator[str]:
    """What became of them; then how that is known, and what it cost."""
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
    """A line a result of samples."""
    for result in results:
        if result.ensemble is not None:
            yield f"{result.name}: {'; '.join(ensemble_lines(result.ensemble))}"


def levels_told(fell: Mapping[int, int]) -> str:
    """At which levels, and half of them by which."""
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
    """Which through which, why, and what that leaves in doubt."""
    seen = (
        f"{passed.brick} passed through {passed.through} by {passed.time:.3f} s, {mm(passed.travel)} from look to look"
    )
    why = "the engine's steps are too long for that speed"
    return f"{seen}: {why}, and what the hit does is not to be trusted; throw it more slowly, or play it on `exact`"


def passed_through(results: Iterable[VariantResult]) -> Iterator[str]:
    """A line for each run in which that happened."""
    for result in results:
        if result.passed_through is not None:
            yield f"{result.name}: {passed_text(result.passed_through)}"
