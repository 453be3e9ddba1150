"""Renders Markdown: figures between markers are replaced by the current values of the data.

A single figure is part of running text or of a cell: <!-- figure: FILE/TABLE/ROW/KEY FORM -->0.15<!-- end -->. A table
is on lines of its own between <!-- table: NAME --> and <!-- end -->; `tables.py` defines its content.
"""

import re
from collections.abc import Callable

from benchmarks.figures.columns import Table
from benchmarks.figures.data import Data, load
from benchmarks.figures.file_formats import with_files
from benchmarks.figures.forms import written
from benchmarks.figures.rooms import with_rooms
from benchmarks.figures.tables import TABLES

FIGURE = re.compile(r"(<!-- figure: (?P<path>[^>]+?)(?: (?P<form>[^ />]+))? -->)(?P<shown>[^<]*)(<!-- end -->)")
TABLE = re.compile(r"(<!-- table: (?P<name>[^>]+?) -->\n)(?P<shown>(?:\|[^\n]*\n)*)(<!-- end -->)")
Load = Callable[[str], Data]


def rendered(text: str, load_data: Load = load) -> str:
    """Return the text with the latest value of every figure."""
    with_tables = TABLE.sub(
        lambda found: f"{found[1]}{table_text(TABLES[found['name']], load_data)}{found[4]}",
        with_files(with_rooms(text)),
    )
    return FIGURE.sub(lambda found: f"{found[1]}{_figure(found, load_data)}{found[5]}", with_tables)


def _figure(found: re.Match[str], load_data: Load) -> str:
    name, table, rest = found["path"].split("/", 2)
    row, _, key = rest.rpartition("/")  # the name of a row may contain a unit with a slash
    return written(load_data(name).value(table, row, key), found["form"] or "")


def table_text(table: Table, load_data: Load = load) -> str:
    """Return a table with its heading."""
    rows = load_data(table.data).tables[table.of]
    lines = [[column.heading for column in table.columns], ["---"] * len(table.columns)]
    for name in table.rows or rows:
        lines.append([column.cell(name, rows[name]) for column in table.columns])
    return "".join(f"| {' | '.join(line)} |\n" if line[0] != "---" else f"|{'|'.join(line)}|\n" for line in lines)
