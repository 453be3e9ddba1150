"""Blocks of lines and tables for a terminal or a file."""

from collections.abc import Iterable, Sequence
from io import StringIO
from typing import TypeAlias

from rich.console import Console
from rich.table import Table
from rich.text import Text

from stackdsl.trace import NUMERICAL_COLLAPSE

UNBOUNDED = 10_000  # [characters] more than any table takes
STYLES = (
    dict.fromkeys(("stands", "same", "agrees"), "green")
    | dict.fromkeys(("written", "differs", "not run"), "yellow")
    | dict.fromkeys(
        ("missing", "different", "unreadable", "blocked", "crashed", "timed out", NUMERICAL_COLLAPSE), "red"
    )
)

Row: TypeAlias = dict[str, str]  # by column
Block: TypeAlias = Sequence[Text | Table]


def blocks_text(blocks: Iterable[Block], width: int, colour: bool) -> str:
    """Blocks with a blank line between; tables keep to `width` [characters] where words let them."""
    console = Console(
        file=StringIO(),
        width=UNBOUNDED,
        force_terminal=colour,
        color_system="standard" if colour else None,
        no_color=not colour,
        legacy_windows=False,
    )
    with console.capture() as capture:
        for number, block in enumerate(blocks):
            if number:
                console.print()
            for part in block:
                console.print(part, width=width if isinstance(part, Table) else None, soft_wrap=isinstance(part, Text))
    return "\n".join(line.rstrip() for line in capture.get().split("\n"))


def line(text: str, style: str = "") -> Text:
    """Text of others, such as names out of a file, kept from steering the terminal."""
    safe = "".join(character if character.isprintable() or character == "\n" else "\ufffd" for character in text)
    return Text(safe, style=style)


def table(rows: Sequence[Row], left: Sequence[str]) -> Table:
    """A table without rules, which can be searched and pasted; words to the left, numbers to the right."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="bold")
    for name in rows[0]:
        # Lines break between words only: a name cut in two can be neither read nor searched.
        longest = max(len(word) for text in (name, *(row[name] for row in rows)) for word in text.split(" "))
        table.add_column(name, justify="left" if name in left else "right", min_width=longest, overflow="fold")
    for row in rows:
        table.add_row(*(line(cell, STYLES.get(cell, "")) for cell in row.values()))
    return table


def titled(title: str, lines: Sequence[str]) -> Block:
    """Lines below a title; nothing where there are none."""
    return [line(title, "bold"), *(line(f"  {each}") for each in lines)] if lines else []
