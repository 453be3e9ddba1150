"""Differences from a golden file in words: each brick once for an observation, equal changes together."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from operator import itemgetter

from stability.name_order import MOST_NAMES, names_text, natural_key
from stackdsl.goldens.comparison import ABSENT
from stackdsl.report.blocks import GAP, hanging
from stackdsl.results import GoldenDifference, GoldenResult, GoldenStatus
from stackdsl.trace import BrickState
from stackdsl.wording import and_text, how_many, significant

MOST_ALIKE = 3  # different changes of one observation that are listed one by one
MOST_LINES = 100  # of one golden file; a fallen tower has ten thousand differences
STATES = {  # in words
    BrickState.FROZEN.value: "stands, proven",
    BrickState.STANDING.value: "stands, not proven",
    BrickState.DISPLACED.value: "stands, displaced",
    BrickState.FALLEN.value: "fell",
    BrickState.THROWN.value: "thrown or dropped",
    BrickState.UNSETTLED.value: "still moving",
    BrickState.REMOVED.value: "pulled out",
    BrickState.UNPLACED.value: "never placed",
    BrickState.UNWATCHED.value: "not simulated",
}
NOTHING = {  # in words, by observation, where one side has none
    **dict.fromkeys(("collapse level", "collapse time"), "no collapse"),
    **dict.fromkeys(("rests on", "rests on when placed"), "nothing"),
    **dict.fromkeys(("brick", "plane"), "absent"),
    "placed at": "not placed",
    "gave way": "no brick",
    "pulled out at": "not pulled out",
    "pushed at": "not pushed",
    "margin": "no margin",
}
PROVEN_OR_NOT = {BrickState.FROZEN.value, BrickState.STANDING.value}  # it stands in both cases
FELL = BrickState.FALLEN.value
EXACT = "exact"  # no tolerance
LOCKED = (GoldenStatus.NEW, GoldenStatus.WRITTEN)
UNCLEAR = "unclear"  # label of what is not compared
VERDICT, STATE, STRUCTURE, PLACES = "verdict", "state", "structure", ("x", "y", "z")  # in differences


def unclear_lines(goldens: Iterable[GoldenResult]) -> Iterator[str]:
    """Yield what golden files that were just written do not lock: of one file by name, of several by number."""
    locked = (golden for golden in goldens if golden.status in LOCKED and not golden.differences)  # others list it
    unclear = [golden for golden in locked if golden.unclear.text]
    if len(unclear) == 1:
        yield f"{unclear[0].file}: {unclear[0].unclear.text}"
    elif unclear:
        states, places = (sum(len(getattr(each.unclear, kind)) for each in unclear) for kind in ("states", "places"))
        told = [how_many(count, noun) for count, noun in ((states, "state"), (places, "place")) if count]
        files = names_text([golden.file for golden in unclear])
        yield f"{and_text(told) or 'observations'} in {len(unclear)} files are unclear and not compared: {files}"


def difference_lines(
    golden: GoldenResult, width: int, every: bool = False, remedy: str = "--format json lists all"
) -> list[str]:
    """Return the differences as lines of an observation and its changes, at most `MOST_LINES`, and what is unclear.

    With `every`, the change of every brick is listed. Otherwise `remedy` says how to list the lines that are left out.
    """
    folded = list(folded_differences(golden, every))
    label = max((len(quantity) for quantity, _ in folded), default=0)
    lines, unclear = list[str](), list[str]()
    for quantity, told in folded:
        block = unclear if quantity == UNCLEAR else lines
        block += hanging(f"{GAP}{quantity:<{label}}{GAP}{told}", width)
    if len(lines) > MOST_LINES and not every:
        lines[MOST_LINES:] = [f"{GAP}and {len(lines) - MOST_LINES} more lines; {remedy}"]
    return [*lines, *unclear]


def folded_differences(golden: GoldenResult, every: bool = False) -> Iterator[tuple[str, str]]:
    """Yield each observation with the bricks that changed alike, or with the largest change of many bricks.

    With `every`, all changes of many bricks are listed.

    The verdict comes first, then the number of bricks that fell, which bricks fell, other changes of their states, and
    what moved most. What is unclear comes last: without it, the differences would seem to be all.
    """
    verdicts = [each for each in golden.differences if each.quantity == VERDICT]
    yield from _folded(verdicts, every)
    if golden.fallen_text:
        label, _, counts = golden.fallen_text.partition(" ")
        yield label, counts
    if golden.differences and golden.fallen is not None and golden.fallen.first:
        yield "first fall", golden.fallen.first
    yield from _folded([each for each in golden.differences if each.quantity != VERDICT], every)
    if golden.unclear.text:
        yield UNCLEAR, golden.unclear.text


def _folded(differences: Sequence[GoldenDifference], every: bool) -> Iterator[tuple[str, str]]:
    alike: defaultdict[tuple[str, str, str], list[GoldenDifference]] = defaultdict(list)
    for each in sorted(differences, key=_rank):
        # All changes of a state are listed one by one, as they are few.
        change = (each.expected, each.got) if each.quantity == STATE else ("", "")
        alike[each.quantity, *change].append(each)
    for (quantity, _, _), unsorted in alike.items():
        yield from ((quantity, text) for text in _changes(sorted(unsorted, key=_by_name), every))


def _rank(difference: GoldenDifference) -> tuple[int, float]:
    """Return the sort key of a difference: smaller is more important."""
    if difference.quantity == VERDICT:
        return 0, 0.0
    if difference.quantity == STATE:
        changed = {difference.expected, difference.got}
        return (6 if changed <= PROVEN_OR_NOT else 1 if FELL in changed else 2), 0.0
    if difference.subject == STRUCTURE:
        return 3, 0.0
    return (4, -(_size(difference) or 0.0)) if difference.quantity in PLACES else (5, 0.0)


def _by_name(difference: GoldenDifference) -> tuple[tuple[tuple[str, int], ...], str]:
    return natural_key(difference.subject)


def _changes(found: Sequence[GoldenDifference], every: bool) -> Iterator[str]:
    """Yield the changes of one observation: a line for bricks that changed alike, or one line for all."""
    alike: defaultdict[tuple[str, str], list[GoldenDifference]] = defaultdict(list)
    for each in found:
        alike[each.expected, each.got].append(each)
    if len(alike) > MOST_ALIKE and not every:
        yield f"{_subjects([each.subject for each in found])}{_largest(found)}"
        return
    for (expected, got), equal in alike.items():
        is_state = equal[0].quantity == STATE
        words = STATES if is_state else {ABSENT: NOTHING.get(equal[0].quantity, ABSENT)}
        change = [words.get(text, text) for text in (expected, got)]
        tolerance = equal[0].tolerance
        within = f" (tolerance {tolerance})" if tolerance not in ("", EXACT) else ""
        subjects = _subjects([each.subject for each in equal])
        yield f"{f'{subjects}: ' * (subjects != STRUCTURE)}{' -> '.join(change)}{within}"


def _subjects(names: Sequence[str]) -> str:
    """Return a few names, or the number of many with the first and the last."""
    return names_text(names) if len(names) <= MOST_NAMES else f"{len(names)} bricks from {names[0]} to {names[-1]}"


def _largest(found: Sequence[GoldenDifference]) -> str:
    """Return the largest change of numbers, with the brick, its old and its new value."""
    sizes = [(size, each) for each in found if (size := _size(each)) is not None]
    if not sizes:
        return ": changed"
    size, most = max(sizes, key=itemgetter(0))
    return f": by up to {significant(size)} {most.unit}".rstrip() + f" ({most.subject}: {most.expected} -> {most.got})"


def _size(difference: GoldenDifference) -> float | None:
    """Return the size of a change of a number, in its unit."""
    before, after = difference.numbers
    return abs(after - before) if before is not None and after is not None else None
