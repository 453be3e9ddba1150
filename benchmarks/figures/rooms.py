"""The map of packages, each with the first line of its docstring. <!-- rooms: stability --> inserts it."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
ROOMS = re.compile(r"(<!-- rooms: (?P<package>[a-z]+) -->\n)(?:\|[^\n]*\n)*(<!-- end -->)")


def with_rooms(text: str) -> str:
    """Return a text with the current map of each package that it names."""
    return ROOMS.sub(lambda found: f"{found[1]}{rooms_table(found['package'])}{found[3]}", text)


def rooms_table(package: str) -> str:
    """Return the table of all packages below one."""
    lines = [f"| `{name}/` | {told} |\n" for name, told in rooms(package)]
    return "| package | content |\n|---|---|\n" + "".join(lines)


def rooms(package: str) -> Iterator[tuple[str, str]]:
    """Yield each package below one by path, with the first line of its docstring."""
    for path in sorted((ROOT / package).rglob("__init__.py")):
        if path.parent != ROOT / package:
            told = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
            yield (
                path.parent.relative_to(ROOT).as_posix(),
                " ".join(told.split("\n\n")[0].split()).replace("|", "&#124;"),
            )
