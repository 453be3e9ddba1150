"""Renders the figures of README and docs from docs/data. Run it with `python -m benchmarks.figures`."""

from rich.console import Console

from benchmarks.figures.pages import ROOT, render


def main() -> None:
    """Render the pages, and print those that changed."""
    for path in render():
        Console().print(f"figures of {path.relative_to(ROOT)} written anew")


if __name__ == "__main__":
    main()
