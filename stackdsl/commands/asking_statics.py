"""What commands have in common that ask statics about the structure of a file: cases, and how rows are told."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import click

from stackdsl.commands.terminal import write_data
from stackdsl.report.orders_text import FORMAT, table_csv

Rows = list[tuple[str, Mapping[str, Any]]]

AS = click.option(
    "--format", "form", type=click.Choice(["text", "csv", "json"]), default="text", help="How it is written."
)


def told(rows: Rows, form: str, extra: Sequence[Mapping[str, Any]] = ()) -> None:
    """Write what is to be read by programs."""
    if form == "csv":
        write_data(table_csv(rows), "csv")
    elif form == "json":
        cases: dict[str, dict[str, Any]] = {}
        for one in extra:
            cases[one["case"]] = {**one, "rows": []}
        for name, row in rows:
            cases.setdefault(name, {"case": name, "rows": []})["rows"].append(dict(row))
        write_data(json.dumps({"format": FORMAT, "cases": list(cases.values())}, indent=2) + "\n", "json")
