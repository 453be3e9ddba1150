"""Fragments of the changelog are called as the tool that gathers them reads them."""

import re
import subprocess
import sys

import pytest

from tests.paths import ROOT

FRAGMENTS = sorted((ROOT / "changelog.d").glob("*.md"))
NAME = re.compile(r"(\d+(-[a-z0-9-]+)?|\+[a-z0-9-]+)\.(feature|fix)\.md")  # `+` is for changes without an issue


def test_fragments_tell_their_issue_and_what_they_are() -> None:
    assert [path.name for path in FRAGMENTS if not NAME.fullmatch(path.name)] == []


def test_no_fragment_is_empty() -> None:
    assert [path.name for path in FRAGMENTS if not path.read_text(encoding="utf-8").strip()] == []


def test_every_fragment_is_in_what_is_not_released_yet() -> None:
    pytest.importorskip("towncrier", reason="towncrier is in the extra dev")
    draft = [sys.executable, "-m", "towncrier", "build", "--draft", "--version", "unreleased"]
    told = subprocess.run(draft, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    words = " ".join(told.split())
    assert [
        path.name for path in FRAGMENTS if path.read_text(encoding="utf-8").split("\n")[0].strip() not in words
    ] == []
