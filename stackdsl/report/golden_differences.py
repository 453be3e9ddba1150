"""Differences from a golden file in words: each brick once for an observation, equal changes together."""

from collections import defaultdict
from collections.abc import Iterator, Sequence

from stability.name_order import MOST_NAMES, names_text, natural_key
from stackdsl.report.blocks import GAP, hanging
from stackdsl.report.text import significant
from stackdsl.results import GoldenDifference

MOST_ALIKE = 3  # different changes of one observation that are listed one by one
MOST_LINES = 100  # of one golden file; a fallen tower has ten thousand differences


def difference_lines(differences: Sequence[GoldenDifference], width: int) -> list[str]:
    """Return the differences as lines of an observation and its changes, at most `MOST_LINES`."""
    folded = list(folded_differences(differences))
    label = max((len(quantity) for quantity, _ in folded), default=0)
    lines = [text for quantity, told in folded for text in hanging(f"{GAP}{quantity:<{label}}{GAP}{told}", width)]
    if len(lines) <= MOST_LINES:
        return lines
    return [*lines[:MOST_LINES], f"{GAP}and {len(lines) - MOST_LINES} more lines; --format json lists all"]


def folded_differences(differences: Sequence[GoldenDifference]) -> Iterator[tuple[str, str]]:
    """Yield each observation with the bricks that changed alike, or with the largest change of many bricks."""
    by_quantity: defaultdict[str, list[GoldenDifference]] = defaultdict(list)
    for difference in differences:
        by_quantity[difference.quantity].append(difference)
    for quantity, unsorted in by_quantity.items():
        found = sorted(unsorted, key=lambda difference: natural_key(difference.subject))
        alike: defaultdict[tuple[str, str], list[str]] = defaultdict(list)
        for each in found:
            alike[each.expected, each.got].append(each.subject)
        if len(alike) > MOST_ALIKE:
            yield quantity, f"{_subjects([each.subject for each in found])}{_largest(found)}"
            continue
        for (expected, got), subjects in alike.items():
            tolerance = next(each.tolerance for each in found if each.expected == expected)
            within = f" (tolerance {tolerance})" if tolerance else ""
            yield quantity, f"{_subjects(subjects)}: {expected} -> {got}{within}"


def _subjects(names: Sequence[str]) -> str:
    """Return a few names, or the number of many with the first and the last."""
    return names_text(names) if len(names) <= MOST_NAMES else f"{len(names)} bricks from {names[0]} to {names[-1]}"


def _largest(found: Sequence[GoldenDifference]) -> str:
    """Return the largest change of numbers."""
    sizes = [(abs(b - a), each.unit) for each in found for a, b in [each.numbers] if a is not None and b is not None]
    if not sizes:
        return ": changed"
    size, unit = max(sizes)
    return f": by up to {significant(size)} {unit}".rstrip()
