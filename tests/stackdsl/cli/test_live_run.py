"""`stackdsl run --watch` shows a file in a page, and anew whenever it is saved; Ctrl-C ends it in order."""

import json
import re
import signal
import subprocess
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPResponse
from pathlib import Path
from typing import Any

import pytest

from tests.command_line import AMPLE, GOOD, Stackdsl, saved, started

WRONG = GOOD.replace("levels", "lvels").replace("good", "<b>good")


@contextmanager
def watched(folder: Path, *arguments: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The command under way, and the address that it tells."""
    with started(folder, *arguments) as process:
        try:
            assert process.stderr is not None
            told = process.stderr.readline()
            found = re.fullmatch(r"open (http://127\.0\.0\.1:\d+/[\w-]{32}/)\n", told)
            assert found is not None, told + process.stderr.read()
            yield process, found[1]
        finally:
            process.kill()


def heard(stream: HTTPResponse) -> tuple[str, Any]:
    """The next event that says anything."""
    while not (line := stream.readline().decode()).startswith("event: "):
        assert line, "the stream has ended"
    kind = line.removeprefix("event: ").strip()
    return kind, json.loads(stream.readline().decode().removeprefix("data: "))


def next_of(stream: HTTPResponse, kind: str) -> Any:  # noqa: ANN401 -- whatever the page is told
    while (event := heard(stream))[0] != kind:
        pass
    return event[1]


@pytest.mark.usefixtures("interruptible")
def test_a_save_is_shown_and_a_mistake_is_told_beside_what_was_there(tmp_path: Path) -> None:
    file = tmp_path / "good.yaml"
    file.write_text(GOOD, encoding="utf-8")
    with watched(tmp_path, "run", "--watch", "good.yaml") as (process, url):
        with urllib.request.urlopen(url, timeout=AMPLE) as page:
            assert b"connect-src 'self'" in page.read()
        with urllib.request.urlopen(f"{url}events", timeout=AMPLE) as stream:
            assert len(next_of(stream, "run")["told"]["bricks"]["name"]) == 3
            while not (lines := next_of(stream, "lines")["lines"]):
                pass
            assert any("it survives" in line for line in lines)
            saved(file, WRONG)
            while not (mistakes := next_of(stream, "status")["mistakes"]):
                pass
            assert any("unknown key 'lvels'" in str(mistake) for mistake in mistakes)
            with urllib.request.urlopen(f"{url}events", timeout=AMPLE) as another:  # who comes now sees the last run
                assert len(next_of(another, "run")["told"]["bricks"]["name"]) == 3
            saved(file, GOOD.replace("levels: 3", "levels: 5"))
            while len(next_of(stream, "run")["told"]["bricks"]["name"]) != 5:
                pass  # a mistake ends nothing: what was played before it may still come
            while next_of(stream, "status")["doing"]:
                pass
        process.send_signal(signal.SIGINT)
        assert process.wait(AMPLE) == 0
        assert process.stderr is not None
        assert "Traceback" not in process.stderr.read()


@pytest.mark.usefixtures("interruptible")
def test_a_check_that_watches_serves_the_pages_that_it_writes(tmp_path: Path) -> None:
    pytest.importorskip("watchfiles")
    (tmp_path / "good.yaml").write_text(GOOD, encoding="utf-8")
    with watched(tmp_path, "check", "--watch", "good.yaml", "--html", "report", "--no-golden") as (process, url):
        with urllib.request.urlopen(f"{url}events", timeout=AMPLE) as stream:
            assert heard(stream) == ("written", None)
        with urllib.request.urlopen(f"{url}index.html", timeout=AMPLE) as page:
            assert b"good[exact]" in page.read()
        process.send_signal(signal.SIGINT)
        assert process.wait(AMPLE) == 0


def test_run_watch_refuses_files_that_cannot_be_watched(tmp_path: Path, stackdsl: Stackdsl) -> None:
    (tmp_path / "good.yaml").write_text(GOOD, encoding="utf-8")
    assert "none.yaml does not exist" in stackdsl("run", "--watch", "none.yaml").err
    assert "--watch needs a file, not the standard input" in stackdsl("run", "--watch", "-").err
    assert "--watch writes no files" in stackdsl("run", "--watch", "good.yaml", "--html", "a.html").err
