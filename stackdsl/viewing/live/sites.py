"""What is served: a page that plays runs, or the pages of a folder. Nothing else of this machine can be asked for."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Protocol

from stackdsl.disk import read_file
from stackdsl.project_file import confined
from stackdsl.viewing.replay.replay_page import hash_of

EVENTS: Final = "events"  # where a page hears of changes
INDEX: Final = "index.html"

# A frame around the pages of a folder, which loads again what it shows whenever that was written anew.
RELOADER: Final = (
    "const frame=document.querySelector('iframe');let seen=false;"
    "new EventSource('events').addEventListener('written',()=>{"
    "if(seen)frame.contentWindow.location.reload();seen=true})"
)
FRAME_STYLE: Final = "html,body,iframe{margin:0;border:0;width:100%;height:100%;display:block}"


class Site(Protocol):
    """What answers for the addresses below the token."""

    def page(self, path: str) -> bytes | None:
        """The page of an address, such as `index.html`; None if there is none."""


@dataclass(frozen=True)
class OnePage:
    """A page, and nothing beside it."""

    text: str

    def page(self, path: str) -> bytes | None:
        """The page, where no name is given."""
        return self.text.encode() if not path else None


@dataclass(frozen=True)
class Folder:
    """The pages below a folder, in a frame that loads them again when they are written."""

    root: Path

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


def _frame() -> str:
    policy = (
        f"default-src 'none'; frame-src 'self'; connect-src 'self'; script-src {hash_of(RELOADER)}; "
        f"style-src {hash_of(FRAME_STYLE)}; base-uri 'none'; form-action 'none'"
    )
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>stackdsl check</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}"><style>{FRAME_STYLE}</style></head>'
        f'<body><iframe src="{INDEX}" title="report"></iframe><script>{RELOADER}</script></body></html>'
    )
