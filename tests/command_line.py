"""The command as a process of its own."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from subprocess import PIPE
from typing import NamedTuple

import pytest

from tests import paths

GOOD = """\
scenario: good
build:
  - column: {levels: 3}
    every: 1 s
expect:
  - stands: all
"""


AMPLE = 300.0  # [s] for what takes a few, on a machine that does much else


class Result(NamedTuple):
    """How a command ended, and what it said."""

    code: int
    out: str
    err: str

    @property
    def text(self) -> str:
        return self.out + self.err


Stackdsl = Callable[..., Result]
ROOT = str(paths.ROOT)


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
    done = subprocess.run(
        [sys.executable, "-m", "stackdsl", *arguments],
        cwd=folder,
        env=_clean() | environment,
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    return _without_traceback(Result(done.returncode, done.stdout, done.stderr))


def _clean() -> dict[str, str]:
    """The environment of this process, without what tells the command of it."""
    kept = {key: value for key, value in os.environ.items() if key not in ("CI", "STACKDSL_DEBUG")}
    return kept | {"PYTHONPATH": ROOT}


def _without_traceback(result: Result) -> Result:
    assert "Traceback" not in result.text
    return result


# Most of what a call takes goes into starting Python and importing the command, so one process does both, once, and
# forks another for each call, which then has a folder, arguments and an exit code of its own.
FORKING = """
import json, os, sys
import click
from stackdsl.__main__ import main
from stackdsl.commands.main import COMMANDS, app

for name in COMMANDS:
    app.get_command(click.Context(app), name)
for line in sys.stdin:
    folder, arguments, out, err = json.loads(line)
    child = os.fork()
    if not child:
        for stream, path in enumerate((os.devnull, out, err)):
            os.dup2(os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC), stream)
        os.chdir(folder)
        sys.argv = ["stackdsl", *arguments]
        main()
        sys.exit()
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Lets an interrupt mean what it means to somebody at a terminal, here and in whatever is started meanwhile.

    What is started in the background of a shell, or by `nohup`, ignores it, and so does all that this starts in turn.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session")
def forking() -> Iterator[subprocess.Popen[str]]:
    """The command, imported and ready to be called."""
    command = [sys.executable, "-c", FORKING]
    with subprocess.Popen(command, env=_clean(), stdin=PIPE, stdout=PIPE, encoding="utf-8") as process:
        yield process


@pytest.fixture(name="stackdsl")
def stackdsl_in_folder(
    forking: subprocess.Popen[str], tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> Stackdsl:
    """The command, to be called in the folder of the test."""
    said = tmp_path_factory.mktemp("said")

    def call(*arguments: str, **environment: str) -> Result:
        if environment:  # some of which Python reads as it starts
            return ended(tmp_path, *arguments, **environment)
        assert forking.stdin is not None
        assert forking.stdout is not None
        out, err = said / "out", said / "err"
        print(json.dumps([str(tmp_path), arguments, str(out), str(err)]), file=forking.stdin, flush=True)
        code = int(forking.stdout.readline())
        return _without_traceback(Result(code, out.read_text(encoding="utf-8"), err.read_text(encoding="utf-8")))

    return call


def write(folder: Path, text: str | bytes, name: str = "scene.yaml") -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path
