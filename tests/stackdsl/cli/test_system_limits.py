"""Limits of the machine are reported in words, with a remedy, and not as a fault of stackdsl."""

import os
import resource
import subprocess
import sys
from collections.abc import Callable
from errno import EMFILE, ENOMEM, ENOSPC
from pathlib import Path

import pytest

from stackdsl.cli.main import refused_by_the_system
from stackdsl.exits import ExitCode
from tests.command_line import AMPLE, GOOD, write
from tests.paths import ROOT


def run(folder: Path, *arguments: str, before: Callable[[], None] | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "stackdsl", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        preexec_fn=before,
        capture_output=True,
        text=True,
        check=False,
        timeout=AMPLE,
    )


def test_a_directory_that_is_gone_is_told(tmp_path: Path) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    done = run(folder, "check", before=folder.rmdir)
    assert (done.returncode, done.stdout) == (ExitCode.USAGE, "")
    assert done.stderr.strip() == "the working directory does not exist any more: change to another directory"


def test_too_few_files_that_may_be_open_are_told(tmp_path: Path) -> None:
    write(tmp_path, GOOD, "scenarios/good.yaml")
    done = run(tmp_path, "check", before=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (8, 8)))
    assert done.returncode == ExitCode.CRASHED
    assert "too many open files: raise the limit" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (OSError(EMFILE, "Too many open files"), "too many open files"),
        (OSError(ENOMEM, "Cannot allocate memory"), "out of memory"),
        (MemoryError(), "out of memory"),
        (OSError(ENOSPC, "No space left on device", "golden/a.json"), "the disk is full: golden/a.json"),
        (OSError("something else"), ""),
        (ValueError("a fault of ours"), ""),
    ],
)
def test_an_error_of_the_system_is_put_into_words(error: Exception, words: str) -> None:
    assert words in refused_by_the_system(error)
    assert bool(words) == bool(refused_by_the_system(error))
