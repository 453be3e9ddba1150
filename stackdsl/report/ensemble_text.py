"""What became of many samples, in a few words."""

from collections.abc import Iterable, Iterator, Mapping

from stackdsl.ensemble import Ensemble
from stackdsl.outcome import VariantResult


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
