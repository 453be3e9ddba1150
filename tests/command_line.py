"""The command as a process of its own."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from subprocess import PIPE
from typing import NamedTuple

import pytest

from tests import paths
from tests.engines_at_hand import HAS_PYBULLET

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
StackdslIn = Callable[..., Result]  # with the folder first
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
    kept = {key: value for key, value in os.environ.items() if key not in ("CI", "COLUMNS", "STACKDSL_DEBUG")}
    return kept | {"PYTHONPATH": ROOT}


def _without_traceback(result: Result) -> Result:
    assert "Traceback" not in result.text
    return result


# Most of what a call takes goes into starting Python and importing what a command needs, so one process does both,
# once, and forks another for each call, which then has a folder, arguments and an exit code of its own. It has played a
# scenario before, so that what is made of modules is there as well. That a command imports all it needs by itself, and
# no more, is for tests that start processes (tests/stackdsl/cli/test_start.py).
FORKING = """
import atexit, functools, gc, importlib, json, os, pkgutil, sys, threading
import stability, stackdsl
from stackdsl.__main__ import main
from stackdsl.checking import cache
from stackdsl.checking.cases import cases_of
from stackdsl.checking.play_case import play_case
from stackdsl.language.yaml.source import parse

ELSEWHERE = ("__main__", "pytest_plugin", "mujoco")  # what ends Python, or may not be installed
for package in (stability, stackdsl):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not set(ELSEWHERE) & set(module.name.split(".")) and (PYBULLET or "pybullet" not in module.name):
            importlib.import_module(module.name)
for case in cases_of(parse(SCENARIO, "played.yaml"))[0]:
    play_case(case.timeline, case.system)
digest = functools.cache(lambda settings, digest=cache.program_digest: digest())
cache.program_digest = lambda: digest(tuple(map(os.environ.get, cache.SETTINGS)))  # no call changes the program
cache.program_digest()
gc.collect()
gc.freeze()  # looking for garbage in it would copy its memory


def ended(program):
    try:
        exec(compile(program, "<string>", "exec"), {"__name__": "__main__"}) if program else main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    return 0


for line in sys.stdin:
    folder, program, arguments, environment, *streams = json.loads(line)
    child = os.fork()
    if not child:
        for stream, (path, flags) in enumerate(zip(streams, (os.O_RDONLY, *[os.O_RDWR | os.O_CREAT | os.O_TRUNC] * 2))):
            os.dup2(os.open(path, flags), stream)
        os.chdir(folder)
        os.environ.update(environment)
        sys.argv = ["stackdsl", *arguments]
        code = ended(program)
        threading._shutdown()
        atexit._run_exitfuncs()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)  # without a word to each of a thousand modules
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Lets an interrupt mean what it means to somebody at a terminal, here and in whatever is started meanwhile.

    What is started in the background of a shell, or by `nohup`, ignores it, and so does all that this starts in turn.
    """
    pressed = signal.signal(signal.SIGINT, signal.default_int_handler)
    closed = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGINT, pressed)
    signal.signal(signal.SIGHUP, closed)


@pytest.fixture(scope="session")
def forking() -> Iterator[subprocess.Popen[str]]:
    """The command, imported and ready to be called."""
    code = f"SCENARIO, PYBULLET = {GOOD!r}, {HAS_PYBULLET}\n{FORKING}"
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, env=_clean(), stdin=PIPE, stdout=PIPE, encoding="utf-8") as process:
        yield process


@pytest.fixture(scope="session")
def stackdsl_in(forking: subprocess.Popen[str], tmp_path_factory: pytest.TempPathFactory) -> StackdslIn:
    """The command, to be called in any folder; or a program in Python instead of it."""
    said = tmp_path_factory.mktemp("said")
    given, out, err = (said / name for name in ("given", "out", "err"))

    def call(folder: Path, *arguments: str, program: str = "", keys: str = "", **environment: str) -> Result:
        if any(name.startswith("PYTHON") for name in environment):  # which Python reads as it starts
            assert not program
            return ended(folder, *arguments, **environment)
        given.write_text(keys, encoding="utf-8")
        assert forking.stdin is not None
        assert forking.stdout is not None
        order = [str(folder), program, arguments, environment, *map(str, (given, out, err))]
        print(json.dumps(order), file=forking.stdin, flush=True)
        code = int(forking.stdout.readline())
        return _without_traceback(Result(code, out.read_text(encoding="utf-8"), err.read_text(encoding="utf-8")))

    return call


@pytest.fixture(name="stackdsl")
def stackdsl_in_folder(stackdsl_in: StackdslIn, tmp_path: Path) -> Stackdsl:
    """The command, to be called in the folder of the test."""
    return partial(stackdsl_in, tmp_path)


def write(folder: Path, text: str | bytes, name: str = "scene.yaml") -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def saved(file: Path, text: str) -> None:
    """Save a file that is watched, at one stroke as editors do: no watcher sees it empty or half written."""
    fresh = file.with_name(f".{file.name}.fresh")
    fresh.write_text(text, encoding="utf-8")
    fresh.replace(file)
