"""Serves live pages and reports to browsers on this machine."""

import hmac
import os
import socket
import threading
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from time import monotonic
from typing import Any, Final, Protocol
from urllib.parse import unquote, urlsplit

from stackdsl.disk import read_file
from stackdsl.project_file import confined
from stackdsl.viewing.replay.page import LOADER, policy_of, program_and_style

# What is served: a page that plays runs, or the pages of a folder. Nothing else of this machine can be asked for.


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


class WebSite(Protocol):
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
    from stackdsl.viewing.check_report.page import script_and_style  # noqa: PLC0415 -- only folders need it

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


# What there is to show now, under a few names: whoever looks gets all of it, and then whatever changes.


@dataclass
class Board:
    """Texts by name, each the newest of its name; written by one thread, read by any number."""

    _texts: dict[str, tuple[int, str]] = field(default_factory=dict)  # with the number of the change that brought each
    _changes: int = 0
    _changed: threading.Condition = field(default_factory=threading.Condition)

    def put(self, name: str, text: str) -> None:
        """Show a text under a name, instead of what was there."""
        with self._changed:
            self._changes += 1
            self._texts[name] = self._changes, text
            self._changed.notify_all()

    def drop(self, name: str) -> None:
        """Show nothing under a name any more; who has seen it is not told."""
        with self._changed:
            self._texts.pop(name, None)

    def follow(self, patience: float) -> Iterator[tuple[str, str]]:
        """All that is there, and then every change, in their order and without what was overtaken meanwhile.

        An empty pair whenever nothing has changed for so long [s].
        """
        seen = 0
        while True:
            news, seen = self._news(seen, patience)
            yield from news or [("", "")]

    def _news(self, seen: int, patience: float) -> tuple[list[tuple[str, str]], int]:
        until = monotonic() + patience
        with self._changed:
            while self._changes == seen and (left := until - monotonic()) > 0.0:
                self._changed.wait(left)
            fresh = sorted((number, name, text) for name, (number, text) in self._texts.items() if number > seen)
            return [(name, text) for _, name, text in fresh], self._changes


# Serves a site to browsers of this machine, and tells them of changes as events (Server-Sent Events).
#
# The standard library does: one page, one stream of texts and a handful of readers need no framework, and nothing more
# to install. It listens on the loopback interface alone, knows only addresses that begin with a token that nobody can
# guess, and answers only who calls it by the name of this machine: a foreign page, whose name somebody lets point here
# (DNS rebinding), gets nothing. No request changes anything.


HOST: Final = "127.0.0.1"
SLOWEST: Final = 30.0  # [s] for a browser to say what it wants, and to take what it gets
ALIVE: Final = 10.0  # [s] between signs of life, by which a reader that is gone is noticed
FRAMED: Final = "frame-ancestors 'self'"
HEADERS: Final = {
    "Cache-Control": "no-store",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


def listening() -> socket.socket:
    """A socket that only this machine reaches, on a port that is free. Raises OSError."""
    found = socket.create_server((HOST, 0), backlog=16)
    found.settimeout(None)
    return found


class PageServer(ThreadingHTTPServer):
    """Serves one site under one token, from a socket that listens."""

    daemon_threads = True

    def __init__(self, listener: socket.socket, token: str, site: WebSite, board: Board) -> None:
        super().__init__((HOST, 0), Handler, bind_and_activate=False)
        self.socket.close()
        self.socket = listener
        self.server_address = listener.getsockname()
        self.token, self.site, self.board = token, site, board
        port = listener.getsockname()[1]
        self.names = {f"{HOST}:{port}", f"localhost:{port}"}

    def handle_error(self, request: object, client_address: object) -> None:
        """A browser that goes away in the middle is nobody's concern."""


class Handler(BaseHTTPRequestHandler):
    """Answers one request."""

    server: PageServer
    timeout = SLOWEST
    server_version, sys_version = "stackdsl", ""

    def do_GET(self) -> None:
        """A page, or the stream of events."""
        if self.headers.get_all("Host") not in [[name] for name in self.server.names]:
            self._answer(HTTPStatus.MISDIRECTED_REQUEST, "text/plain", b"this is served to this machine alone\n")
            return
        _, _, rest = unquote(urlsplit(self.path).path).partition("/")
        token, slash, path = rest.partition("/")
        if not slash or not hmac.compare_digest(token.encode(), self.server.token.encode()):
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"open the address that stackdsl has told\n")
        elif path == EVENTS:
            self._stream()
        elif (page := self.server.site.page(path)) is not None:
            self._answer(HTTPStatus.OK, "text/html", page, self.server.site.policy(path))
        else:
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"there is no such page\n")

    def _answer(self, status: HTTPStatus, kind: str, body: bytes, policy: str = "") -> None:
        allowed = "; ".join(filter(None, [policy, FRAMED]))
        more = {"Content-Length": str(len(body)), "Content-Security-Policy": allowed}
        self._head(status, f"{kind}; charset=utf-8", more)
        self.wfile.write(body)

    def _head(self, status: HTTPStatus, kind: str, more: dict[str, str]) -> None:
        self.send_response(status)
        for name, value in {"Content-Type": kind, **HEADERS, **more}.items():
            self.send_header(name, value)
        self.end_headers()

    def _stream(self) -> None:
        self._head(HTTPStatus.OK, "text/event-stream", {})
        with suppress(OSError):  # it is gone
            for event in events(self.server.board):
                self.wfile.write(event)

    def log_message(self, format: str, *args: Any) -> None:  # noqa: ANN401 -- as the library calls it
        """Nobody reads of every request."""


def events(board: Board) -> Iterator[bytes]:
    """What is on a board as the events of a stream: the kind is the first word of a name."""
    for name, text in board.follow(ALIVE):
        # JSON in one line, in which no text can begin a line of its own.
        yield f"event: {name.split()[0]}\ndata: {text}\n\n".encode() if name else b": alive\n\n"
