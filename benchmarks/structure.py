"""Measures the structure of the code: files and code lines by room, and the path of one check through the modules.

Code lines are lines without blanks, comments and docstrings. The path is traced in the command and its workers, without
what imports execute: modules of which a function runs, hand-overs (calls from one module into another), and calls.

Run: python -m benchmarks.structure [scenario.yaml ...]
"""

import ast
import atexit
import io
import json
import os
import subprocess
import sys
import tempfile
import threading
import tokenize
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Final

from rich.console import Console
from rich.table import Table

ROOT: Final = Path(__file__).parent.parent
PACKAGES: Final = ("stackdsl", "stability")
OUT: Final = "STACKDSL_TRACE"  # environment variable: the directory for the counts of each traced process
NO_CODE: Final = (
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
)
FUNCTION: Final = 0x3  # flags of code objects that are functions, not modules or class bodies
EVERY: Final = 200  # calls between writes of the counts, as a worker may be killed


def main() -> None:
    """Print code lines by room, and the path of a check of each given scenario."""
    rooms = Table("room", "files", "code lines")
    files, lines = Counter[str](), Counter[str]()
    for file in sorted(file for package in PACKAGES for file in (ROOT / package).rglob("*.py")):
        room = "/".join(file.relative_to(ROOT).parts[:-1][:2])
        files[room] += 1
        lines[room] += code_lines(file.read_text(encoding="utf-8"))
    for room in sorted(files):
        rooms.add_row(room, f"{files[room]}", f"{lines[room]:,}")
    rooms.add_row("all", f"{files.total()}", f"{lines.total():,}")
    Console().print(rooms)
    paths = Table("check of", "modules", "hand-overs", "calls")
    for scenario in sys.argv[1:]:
        paths.add_row(scenario, *(f"{count:,}" for count in traced(Path(scenario).resolve())))
    if sys.argv[1:]:
        Console().print(paths)


def code_lines(text: str) -> int:
    """Return the number of lines with code."""
    tree = ast.parse(text)
    documented = [node for node in ast.walk(tree) if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)]
    docstrings = {
        line
        for node in documented
        if ast.get_docstring(node) is not None
        for line in range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1)
    }
    tokens = [token for token in tokenize.generate_tokens(io.StringIO(text).readline) if token.type not in NO_CODE]
    return len({line for token in tokens for line in range(token.start[0], token.end[0] + 1)} - docstrings)


def traced(scenario: Path) -> Iterator[int]:
    """Check a scenario in an empty directory; return the number of modules, hand-overs and calls."""
    with tempfile.TemporaryDirectory() as folder:
        # Python imports this module at the start of each process, workers included.
        Path(folder, "sitecustomize.py").write_text("from benchmarks.structure import trace\ntrace()\n", "utf-8")
        out = Path(folder, "counts")
        out.mkdir()
        environment = {**os.environ, OUT: str(out), "PYTHONPATH": os.pathsep.join([folder, str(ROOT)])}
        Path(folder, scenario.name).write_bytes(scenario.read_bytes())
        command = [sys.executable, "-P", "-m", "stackdsl", "check", scenario.name]
        subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True)
        counts = [json.loads(file.read_text("utf-8")) for file in out.iterdir()]
    yield len({module for count in counts for module in count["modules"]})
    yield sum(count["handovers"] for count in counts)
    yield sum(count["calls"] for count in counts)


def trace() -> None:
    """Count the calls of this process from now on; `OUT` names the directory for the counts."""
    out = os.environ.get(OUT)
    if out is None:
        return
    inside = tuple(str(ROOT / package) + os.sep for package in PACKAGES)
    modules, total = dict[str, None](), Counter[str]()

    def write() -> None:
        counts = {"modules": list(modules), "handovers": total["handovers"], "calls": total["calls"]}
        Path(out, f"{os.getpid()}.json").write_text(json.dumps(counts), "utf-8")

    def profile(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        if event != "call" or code.co_flags & FUNCTION != FUNCTION or not code.co_filename.startswith(inside):
            return
        callers = list(_callers(frame, inside))
        if any(name == "<module>" and not file.endswith("__main__.py") for file, name in callers):
            return  # executed by an import
        total["calls"] += 1
        total["handovers"] += bool(callers) and callers[0][0] != code.co_filename
        if total["calls"] % EVERY == 0 or code.co_filename not in modules:
            modules[code.co_filename] = None
            write()

    threading.setprofile(profile)
    sys.setprofile(profile)
    atexit.register(write)


def _callers(frame: FrameType, inside: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """Yield file and name of the calling functions of these packages, the nearest first."""
    caller = frame.f_back
    while caller is not None:
        if caller.f_code.co_filename.startswith(inside):
            yield caller.f_code.co_filename, caller.f_code.co_name
        caller = caller.f_back


if __name__ == "__main__":
    main()
