"""The command as a process of its own."""

import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

GOOD = """\
scenario: good
build:
  - column: {levels: 3}
    every: 1 s
expect:
  - stands: all
"""


class Result:
    def __init__(self, done: subprocess.CompletedProcess[str]) -> None:
        self.code, self.out, self.err = done.returncode, done.stdout, done.stderr

    @property
    def text(self) -> str:
        return self.out + self.err


Stackdsl = Callable[..., Result]
ROOT = str(Path(__file__).parent.parent)


def started(
    folder: Path,
    *arguments: str,
    program: tuple[str, ...] = ("-m", "stackdsl"),
    executable: str = sys.executable,
    stdout: int = subprocess.PIPE,
    path: str = "",
) -> subprocess.Popen[str]:
    """The command, under way; `path` comes before all other packages."""
    return subprocess.Popen(
        [executable, *program, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [path, ROOT])), "CI": ""},
        stdout=stdout,
        stderr=subprocess.PIPE,
        encoding="utf-8",
    )


def ended(folder: Path, *arguments: str, **environment: str) -> Result:
    """What the command has said in a folder, and how it ended."""
    clean = {key: value for key, value in os.environ.items() if key not in ("CI", "STACKDSL_DEBUG")}
    done = subprocess.run(
        [sys.executable, "-m", "stackdsl", *arguments],
        cwd=folder,
        env={**clean, "PYTHONPATH": ROOT, **environment},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert "Traceback" not in done.stdout + done.stderr
    return Result(done)


@pytest.fixture(name="stackdsl")
def stackdsl_in_folder(tmp_path: Path) -> Stackdsl:
    return partial(ended, tmp_path)


def write(folder: Path, text: str | bytes, name: str = "scene.yaml") -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path
