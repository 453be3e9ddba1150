"""The option `--write` of benchmarks: it stores the results, and renders the texts."""

import argparse
from collections.abc import Mapping

from rich.console import Console

from benchmarks.figures.data import Rows, measured_now, save
from benchmarks.figures.pages import ROOT, render


def parser(description: str | None) -> argparse.ArgumentParser:
    """Return the argument parser of a benchmark, with `--write`."""
    found = argparse.ArgumentParser(description=description)
    found.add_argument("--write", action="store_true", help="to docs/data, and the figures of README and docs anew")
    return found


def record(name: str, command: str, tables: Mapping[str, Rows]) -> None:
    """Store the results, and render the texts that show them."""
    console = Console(stderr=True)
    console.print(f"wrote {save(measured_now(name, command, tables)).relative_to(ROOT)}")
    for path in render():
        console.print(f"figures of {path.relative_to(ROOT)} written anew")
