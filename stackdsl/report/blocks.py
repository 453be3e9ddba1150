"""Blocks of lines and tables for a terminal or a file."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from textwrap import wrap
from typing import TYPE_CHECKING, TypeAlias
from unicodedata import combining, east_asian_width

from stackdsl.shown_text import without_commands
from stackdsl.trace import NUMERICAL_COLLAPSE, UNRELIABLE

if TYPE_CHECKING:
    from rich.table import Table as RichTable

UNBOUNDED = 10_000  # [characters] wider than any table
GAP = "  "  # between two columns
COLUMN_GAP = re.compile(r" {2,}(?=\S)")
DEEPEST = 44  # [characters] the last column below which a wrapped line goes on
INDENT = "    "  # of the folded lines of a row
ANSI = {"green": "32", "yellow": "33", "red": "31"}
STYLES = (
    dict.fromkeys(("stands", "same", "agrees"), "green")
    | dict.fromkeys(("written", "differs", "not run", "skipped", "of another engine"), "yellow")
    | dict.fromkeys(
        ("missing", "different", "unreadable", "blocked", "crashed", "timed out", NUMERICAL_COLLAPSE, UNRELIABLE), "red"
    )
)

Row: TypeAlias = dict[str, str]  # by column


@dataclass(frozen=True, slots=True)
class TextStyle:
    """The extent of a text report."""

    verbosity: int = 0  # -1: only what failed; 1: also every case, passed expectations and all notes
    durations: int = 0  # number of slowest cases to list
    table: bool = False  # whether to add a table with a row for each case


@dataclass(frozen=True, slots=True)
class Line:
    """Text that is not wrapped."""

    text: str
    style: str


@dataclass(frozen=True, slots=True)
class Table:
    """A table without rules, which can be searched and pasted; words to the left, numbers to the right."""

    rows: Sequence[Row]
    left: Sequence[str]  # the columns of words


Block: TypeAlias = Sequence[Line | Table]


def blocks_text(blocks: Iterable[Block], width: int, colour: bool) -> str:
    """Return blocks with a blank line between; tables keep to `width` [characters] if words are short enough."""
    shown = ["".join(_shown(part, width, colour) for part in block) for block in blocks]
    return "\n".join(text.rstrip() for text in "\n".join(shown).split("\n"))


def line(text: str, style: str = "") -> Line:
    """Return a line with control characters made visible, as text may come from a file."""
    return Line(_safe(text), style)


def hanging(text: str, width: int) -> Iterator[str]:
    """Yield a line, wrapped between words, with later lines below its last column: columns have two spaces between."""
    starts = [gap.end() for gap in COLUMN_GAP.finditer(text[:DEEPEST])]
    begin = len(text) - len(text.lstrip())
    indent = starts[-1] if starts and starts[-1] > begin else begin + len(GAP)
    if len(text) <= width:
        yield text
    else:
        yield from wrap(text, width, subsequent_indent=" " * indent, break_long_words=False, break_on_hyphens=False)


def table(rows: Sequence[Row], left: Sequence[str]) -> Table:
    """Return a table of rows, with these columns aligned left."""
    return Table([{name: _safe(cell) for name, cell in row.items()} for row in rows], left)


def _safe(text: str) -> str:
    shown = (character if character.isprintable() or character == "\n" else "\ufffd" for character in text)
    return without_commands("".join(shown))


def titled(title: str, lines: Sequence[str]) -> Block:
    """Return lines below a title; nothing without lines."""
    return [line(title, "bold"), *(line(f"  {each}") for each in lines)] if lines else []


def _shown(part: Line | Table, width: int, colour: bool) -> str:
    if isinstance(part, Table) and part.rows and _breadth(_widths(part)) > width:
        return folded_text(part, width, colour)
    plain = None if colour else plain_text(part, width)
    return plain if plain is not None else drawn_text(part, width, colour)


def plain_text(part: Line | Table, width: int) -> str | None:
    """Return text without colours and without wide columns, which needs no library; None for other text."""
    if isinstance(part, Line):
        return f"{part.text}\n"
    names = list(part.rows[0])
    rows = [names, *([row[name] for name in names] for row in part.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    # Non-ASCII characters may be two columns wide, line breaks make rows higher, and outer spaces may be cut off.
    if sum(widths) + len(GAP) * (len(widths) - 1) > width or not all(_is_simple(cell) for row in rows for cell in row):
        return None
    flush = [str.ljust if name in part.left else str.rjust for name in names]
    return "".join(GAP.join(to(c, w) for to, c, w in zip(flush, row, widths, strict=True)) + "\n" for row in rows)


def folded_text(part: Table, width: int, colour: bool) -> str:
    """Return a table wider than the output, with each row and the header on several lines, the later ones indented.

    Cells are not broken: one wider than the output exceeds it.
    """
    widths = _widths(part)
    groups: list[list[str]] = [[]]
    for name in part.rows[0]:
        room = width - (len(INDENT) if len(groups) > 1 else 0)
        if groups[-1] and _breadth({each: widths[each] for each in (*groups[-1], name)}) > room:
            groups.append([])
        groups[-1].append(name)
    header = {name: name for name in part.rows[0]}
    return "".join(
        f"{INDENT * (number > 0)}{_cells(row, group, part.left, widths, colour)}\n"
        for row in (header, *part.rows)
        for number, group in enumerate(groups)
    )


def _cells(row: Row, names: Sequence[str], left: Sequence[str], widths: Mapping[str, int], colour: bool) -> str:
    cells = []
    for name in names:
        text, gap = row[name], " " * (widths[name] - columns_of(row[name]))
        code = ANSI.get(STYLES.get(text, ""), "") if colour else ""
        shown = f"\x1b[{code}m{text}\x1b[0m" if code else text
        cells.append(shown + gap if name in left else gap + shown)
    return GAP.join(cells).rstrip()


def _widths(part: Table) -> Mapping[str, int]:
    return {name: max(columns_of(text) for text in (name, *(row[name] for row in part.rows))) for name in part.rows[0]}


def _breadth(widths: Mapping[str, int]) -> int:
    return sum(widths.values()) + len(GAP) * (len(widths) - 1)


def columns_of(text: str) -> int:
    """Return the number of terminal columns of a text."""
    if text.isascii():
        return len(text)
    return sum(0 if combining(each) else 1 + (east_asian_width(each) in "WF") for each in text)


def _is_simple(cell: str) -> bool:
    return cell.isascii() and cell.isprintable() and cell == cell.strip()


def drawn_text(part: Line | Table, width: int, colour: bool) -> str:
    """Return blocks with colours and broken rows, drawn by rich."""
    from rich.console import Console  # noqa: PLC0415 -- most output is plain, and it takes a while to load
    from rich.text import Text  # noqa: PLC0415 -- likewise

    console = Console(
        file=StringIO(),
        width=UNBOUNDED,
        force_terminal=colour,
        color_system="standard" if colour else None,
        no_color=not colour,
        legacy_windows=False,
    )
    with console.capture() as capture:
        if isinstance(part, Line):
            console.print(Text(part.text, style=part.style), soft_wrap=True)
        else:
            console.print(_rich_table(part), width=width)
    return capture.get()


def _rich_table(part: Table) -> "RichTable":
    from rich.table import Table as RichTable  # noqa: PLC0415 -- as above
    from rich.text import Text  # noqa: PLC0415 -- likewise

    drawn = RichTable(box=None, pad_edge=False, padding=(0, len(GAP), 0, 0), header_style="bold")
    for name in part.rows[0]:
        # Lines break between words only: a name cut in two can be neither read nor searched.
        longest = max(len(word) for text in (name, *(row[name] for row in part.rows)) for word in text.split(" "))
        drawn.add_column(
            Text(name), justify="left" if name in part.left else "right", min_width=longest, overflow="fold"
        )
    for row in part.rows:
        drawn.add_row(*(Text(row[name], style=STYLES.get(row[name], "")) for name in part.rows[0]))
    return drawn
