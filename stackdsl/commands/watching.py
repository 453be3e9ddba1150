"""`stackdsl check --watch`: checks again whenever a scenario is saved, each time in a new process.

So it is always the code on the disk that plays, and what is remembered says what need not be played again.
"""

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import click

from stackdsl.checking.gathering import SUFFIXES
from stackdsl.commands.terminal import tell
from stackdsl.disk import leads_outside, true_folder
from stackdsl.project_file import confined
from stackdsl.reading.project import root_of

WATCHED = (*SUFFIXES, ".obj")  # not loads in CSV and JSON: reports that a check itself writes may be those


def watch(paths: Sequence[Path], html: Path | None) -> int:
    """Check as this call asks for, now and at every change below these paths; the exit code of the last check.

    The pages that each check writes into a folder, if that is wanted, are served on this machine, and load again.
    """
    if html is None:
        return _watch(paths)
    from stackdsl.viewing.live.showing import showing  # noqa: PLC0415 -- few calls do
    from stackdsl.viewing.live.sites import Folder  # noqa: PLC0415 -- likewise

    try:
        true_folder(html, confined(html))
        with showing(Folder(html)) as page:
            tell(f"open {page.url}")
            return _watch(paths, lambda: page.put("written", None))
    except OSError as error:
        raise click.ClickException(f"no page can be shown: {error.strerror or error}") from error


def _refuse_links_out(folder: Path) -> None:
    """Raise UsageError if there is a link to a folder outside: the library would watch what it leads to as well."""
    for parent, names, _ in os.walk(folder):
        for path in (Path(parent, name) for name in names):
            if path.is_symlink() and leads_outside(path, folder):
                raise click.UsageError(f"{os.path.relpath(path)} is a link out of what is watched; remove it")


def _watch(paths: Sequence[Path], on_checked: Callable[[], None] = lambda: None) -> int:
    try:
        from watchfiles import watch as changes_of  # noqa: PLC0415 -- where something is watched
    except ImportError as error:
        raise click.UsageError(
            "--watch needs watchfiles, which is not installed; try: pip install watchfiles"
        ) from error
    missing = [path for path in paths if not os.path.exists(path)]
    if missing:
        raise click.UsageError(f"{missing[0]} is not there to be watched")
    # -P: without it, modules of the folder that is watched would be run in place of our own.
    command = [sys.executable, "-P", "-m", "stackdsl", *(word for word in sys.argv[1:] if word != "--watch")]
    # A scenario may be made of any file of its project. What does not concern it costs little: the rest is remembered.
    folders = {Path(root_of(str(path / "any" if os.path.isdir(path) else path))) for path in paths}
    for folder in folders:
        _refuse_links_out(folder)

    def is_meant(_: object, name: str) -> bool:
        path = Path(name)
        own = [path.relative_to(folder).parts for folder in folders if path.is_relative_to(folder)]
        hidden = all(any(part.startswith(".") for part in parts) for parts in own)
        return not hidden and path.suffix.lower() in WATCHED

    code = 0
    try:
        changes = changes_of(*folders, watch_filter=is_meant, yield_on_timeout=True, rust_timeout=500)
        for number, changed in enumerate(changes):
            if number and not changed:
                continue
            for name in sorted({Path(name).name for _, name in changed}):
                tell(f"changed: {name}")
            code = subprocess.run(command, check=False).returncode
            on_checked()
            tell("watching; Ctrl-C ends it")
    except KeyboardInterrupt:
        pass
    return code
