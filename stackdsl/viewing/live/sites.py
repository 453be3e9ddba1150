"""What is served: a page that plays runs, or the pages of a folder. Nothing else of this machine can be asked for."""

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Protocol

from stackdsl.disk import read_file
from stackdsl.project_file import confined
from stackdsl.viewing.replay.replay_page import LOADER, policy_of, program_and_style

EVENTS: Final = "events"  # where a page hears of changes
INDEX: Final = "index.html"

# A frame around the pages of a folder, which loads again what it shows whenever that was written anew.
RELOADER: Final = (
    "const frame=document.querySelector('iframe');let seen=false;"
    "new EventSource('events').addEventListener('written',()=>{"
    "if(seen)frame.contentWindow.location.reload();seen=true})"
)
FRAME_STYLE: Final = "html,body,iframe{margin:0;border:0;width:100%;height:100%;display:block}"
_FRAME_POLICY: Final = f"{policy_of((RELOADER,), (FRAME_STYLE,))}; frame-src 'self'; connect-src 'self'"


class Site(Protocol):
    """What answers for the addresses below the token."""

    def page(self, path: str) -> bytes | None:
        """The page of an address, such as `index.html`; None if there is none."""

    def policy(self, path: str) -> str:
        """What a browser lets that page do at most, as a content security policy; empty if the page alone says so."""


@dataclass(frozen=True)
class OnePage:
    """A page, and nothing beside it."""

    text: str

    def page(self, path: str) -> bytes | None:
        """The page, where no name is given."""
        return self.text.encode() if not path else None

    def policy(self, path: str) -> str:
        """This program wrote the page, and it says itself what it may do."""
        return ""


def policy_of_reports() -> str:
    """The policy by which the scripts of pages of a report run, whatever page they are on, and no other script does."""
    from stackdsl.viewing.check_report.index_page import script_and_style  # noqa: PLC0415 -- only folders need it

    (script, style), (program, style_of_replays) = script_and_style(), program_and_style()
    return policy_of((script, LOADER, program), (style, style_of_replays))


@dataclass(frozen=True)
class Folder:
    """The pages below a folder, in a frame that loads them again when they are written.

    A folder may hold pages that somebody else wrote, and reports of earlier calls that are still to be looked at. So
    pages are not told apart by who wrote them: each may run what a report is made of, and nothing else.
    """

    root: Path
    _policy: str = field(default_factory=policy_of_reports)

    def page(self, path: str) -> bytes | None:
        """The frame, where no name is given; else a page that really lies below the folder, wherever links lead."""
        if not path:
            return _frame().encode()
        try:
            file = self.root / path
            confined(file)
            return read_file(file, within=self.root) if Path(os.path.realpath(file)).suffix == ".html" else None
        except (OSError, ValueError):  # a name that no file system takes
            return None

    def policy(self, path: str) -> str:
        """That of the frame, where no name is given; else that of reports."""
        return self._policy if path else _FRAME_POLICY


def _frame() -> str:
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>stackdsl check</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{_FRAME_POLICY}"><style>{FRAME_STYLE}</style></head>'
        f'<body><iframe src="{INDEX}" title="report"></iframe><script>{RELOADER}</script></body></html>'
    )
