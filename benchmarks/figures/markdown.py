"""Markdown with figures between markers -> the same with the figures that the data have now.

A single figure stands in running text or in a cell: <!-- figure: FILE/TABLE/ROW/KEY FORM -->0.15<!-- end -->.
A table stands on lines of its own between <!-- table: NAME --> and <!-- end -->; `tables.py` says what is in it.
"""

import re
from collections.abc import Callable

from benchmarks.figures.columns import Table
from benchmarks.figures.data import Data, load
from benchmarks.figures.forms import written
from benchmarks.figures.rooms import with_rooms
from benchmarks.figures.tables import TABLES

FIGURE = re.compile(r"(<!-- figure: (?P<path>[^>]+?)(?: (?P<form>[^ />]+))? -->)(?P<shown>[^<]*)(<!-- end -->)")
TABLE = re.compile(r"(<!-- table: (?P<name>[^>]+?) -->\n)(?P<shown>(?:\|[^\n]*\n)*)(<!-- end -->)")
Load = Callable[[str], Data]


def rendered(text: str, load_data: Load = load) -> str:
    """The text, with every figure as measured last."""
    with_tables = TABLE.sub(
        lambda found: f"{found[1]}{table_text(TABLES[found['name']], load_data)}{found[4]}", with_rooms(text)
    )
    return FIGURE.sub(lambda found: f"{found[1]}{_figure(found, load_data)}{found[5]}", with_tables)


def _figure(found: re.Match[str], load_data: Load) -> str:
    name, table, rest = found["path"].split("/", 2)
    row, _, key = rest.rpartition("/")  # the name of a row may have a unit with a slash
    return written(load_data(name).value(table, row, key), found["form"] or "")


def table_text(table: Table, load_data: Load = load) -> str:
    """A table, heading and all."""
    rows = load_data(table.data).tables[table.of]
    lines = [[column.heading for column in table.columns], ["---"] * len(table.columns)]
    for name in table.rows or rows:
        lines.append([column.cell(name, rows[name]) for column in table.columns])
    return "".join(f"| {' | '.join(line)} |\n" if line[0] != "---" else f"|{'|'.join(line)}|\n" for line in lines)
