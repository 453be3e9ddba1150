"""The commit of a checkout, read from its files: git itself would run what the configuration of a checkout names."""

import re
from pathlib import Path

HASH = re.compile(r"[0-9a-f]{40}([0-9a-f]{24})?")
REF = re.compile(r"ref: (refs/[\w][\w./-]*)")
MOST = 4096  # bytes read of a file
SHOWN = 10  # characters of a hash


def commit_of(folder: Path) -> str:
    """Return the branch and the short hash of the commit of a folder's checkout; empty if it has none."""
    git = next((each / ".git" for each in (folder, *folder.parents) if (each / ".git").is_dir()), None)
    if git is None or git.is_symlink():
        return ""
    head = _read(git / "HEAD")
    if HASH.fullmatch(head):
        return head[:SHOWN]
    ref = REF.fullmatch(head)
    if ref is None or ".." in ref[1]:
        return ""
    name, found = ref[1].removeprefix("refs/heads/"), _read(git / ref[1])
    if not HASH.fullmatch(found):
        packed = re.search(
            rf"^({HASH.pattern}) {re.escape(ref[1])}$", _read(git / "packed-refs", 1 << 20), re.MULTILINE
        )
        found = packed[1] if packed else ""
    return f"{name} {found[:SHOWN]}" if found else ""


def _read(path: Path, most: int = MOST) -> str:
    try:
        if path.is_symlink():
            return ""
        with path.open("rb") as file:
            return file.read(most).decode("ascii", "replace").strip()
    except OSError:
        return ""
