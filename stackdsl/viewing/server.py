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

# Web sites: a page that replays runs, or the pages of a folder. No other file of this machine is served.


EVENTS: Final = "events"  # address of the stream of changes
INDEX: Final = "index.html"

# Script of a frame around the pages of a folder; it reloads the shown page whenever that is rewritten.
RELOADER: Final = (
    "const frame=document.querySelector('iframe');let seen=false;"
    "new EventSource('events').addEventListener('written',()=>{"
    "if(seen)frame.contentWindow.location.reload();seen=true})"
)
FRAME_STYLE: Final = "html,body,iframe{margin:0;border:0;width:100%;height:100%;display:block}"
_FRAME_POLICY: Final = f"{policy_of((RELOADER,), (FRAME_STYLE,))}; frame-src 'self'; connect-src 'self'"


class WebSite(Protocol):
    """The pages below the token of a server."""

    def page(self, path: str) -> bytes | None:
        """Return the page at a path, such as `index.html`; None if there is none."""

    def policy(self, path: str) -> str:
        """Return the content security policy of a page; empty if only the page itself has one."""


@dataclass(frozen=True)
class OnePage:
    """A site of a single page."""

    text: str

    def page(self, path: str) -> bytes | None:
        """Return the page for the empty path."""
        return self.text.encode() if not path else None

    def policy(self, path: str) -> str:
        """Return no policy, as the page has its own."""
        return ""


def policy_of_reports() -> str:
    """Return the policy that allows the scripts of reports on any page, and no other script."""
    from stackdsl.viewing.check_report.page import script_and_style  # noqa: PLC0415 -- only folders need it

    (script, style), (program, style_of_replays) = script_and_style(), program_and_style()
    return policy_of((script, LOADER, program), (style, style_of_replays))


@dataclass(frozen=True)
class Folder:
    """The pages below a folder, in a frame that reloads them when they are rewritten.

    A folder may contain foreign pages and older reports. All pages are treated alike: each may run the scripts of a
    report, and nothing else.
    """

    root: Path
    _policy: str = field(default_factory=policy_of_reports)

    def page(self, path: str) -> bytes | None:
        """Return the frame for the empty path, otherwise a page in the folder; links out of the folder are refused."""
        if not path:
            return _frame().encode()
        try:
            file = self.root / path
            confined(file)
            return read_file(file, within=self.root) if Path(os.path.realpath(file)).suffix == ".html" else None
        except (OSError, ValueError):  # ValueError for an impossible file name
            return None

    def policy(self, path: str) -> str:
        """Return the policy of the frame for the empty path, otherwise that of reports."""
        return self._policy if path else _FRAME_POLICY


def _frame() -> str:
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>stackdsl check</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{_FRAME_POLICY}"><style>{FRAME_STYLE}</style></head>'
        f'<body><iframe src="{INDEX}" title="report"></iframe><script>{RELOADER}</script></body></html>'
    )


# Published texts by name: a reader first gets all of them, then every change.


@dataclass
class PublishedTexts:
    """The latest text of each name; written by one thread, read by any number."""

    _texts: dict[str, tuple[int, str]] = field(default_factory=dict)  # with the number of the change
    _changes: int = 0
    _changed: threading.Condition = field(default_factory=threading.Condition)

    def put(self, name: str, text: str) -> None:
        """Publish a text under a name, in place of an earlier one."""
        with self._changed:
            self._changes += 1
            self._texts[name] = self._changes, text
            self._changed.notify_all()

    def drop(self, name: str) -> None:
        """Remove the text of a name; readers are not notified."""
        with self._changed:
            self._texts.pop(name, None)

    def follow(self, patience: float) -> Iterator[tuple[str, str]]:
        """Yield all texts, and then every change in order; texts that were replaced meanwhile are skipped.

        Yields an empty pair after every `patience` seconds without a change.
        """
        seen = 0
        while True:
            changes, seen = self._changes_since(seen, patience)
            yield from changes or [("", "")]

    def _changes_since(self, seen: int, patience: float) -> tuple[list[tuple[str, str]], int]:
        until = monotonic() + patience
        with self._changed:
            while self._changes == seen and (left := until - monotonic()) > 0.0:
                self._changed.wait(left)
            fresh = sorted((number, name, text) for name, (number, text) in self._texts.items() if number > seen)
            return [(name, text) for _, name, text in fresh], self._changes


# Serves a site to browsers of this machine, and sends changes as Server-Sent Events.
#
# The standard library suffices: one page, one stream of texts and a few readers need no framework. The server listens
# only on the loopback interface, serves only addresses that begin with an unguessable token, and answers only requests
# with the host name of this machine, so a foreign page gets nothing by DNS rebinding. No request changes any state.


HOST: Final = "127.0.0.1"
SLOWEST: Final = 30.0  # [s] time limit for a browser to send a request and to receive the answer
ALIVE: Final = 10.0  # [s] between keep-alive messages, which detect readers that have left
FRAMED: Final = "frame-ancestors 'self'"
HEADERS: Final = {
    "Cache-Control": "no-store",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


def listening() -> socket.socket:
    """Return a listening socket on a free port of the loopback interface. Raises OSError."""
    listener = socket.create_server((HOST, 0), backlog=16)
    listener.settimeout(None)
    return listener


class PageServer(ThreadingHTTPServer):
    """Serves one site under one token, from a listening socket."""

    daemon_threads = True

    def __init__(self, listener: socket.socket, token: str, site: WebSite, board: PublishedTexts) -> None:
        super().__init__((HOST, 0), Handler, bind_and_activate=False)
        self.socket.close()
        self.socket = listener
        self.server_address = listener.getsockname()
        self.token, self.site, self.board = token, site, board
        port = listener.getsockname()[1]
        self.names = {f"{HOST}:{port}", f"localhost:{port}"}

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore a browser that closes its connection early."""


class Handler(BaseHTTPRequestHandler):
    """Answers one request."""

    server: PageServer
    timeout = SLOWEST
    server_version, sys_version = "stackdsl", ""

    def do_GET(self) -> None:
        """Answer with a page or the stream of events."""
        if self.headers.get_all("Host") not in [[name] for name in self.server.names]:
            self._answer(HTTPStatus.MISDIRECTED_REQUEST, "text/plain", b"this server answers only to this machine\n")
            return
        _, _, rest = unquote(urlsplit(self.path).path).partition("/")
        token, slash, path = rest.partition("/")
        if not slash or not hmac.compare_digest(token.encode(), self.server.token.encode()):
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", b"open the address that stackdsl has printed\n")
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
        with suppress(OSError):  # the browser has left
            for event in events(self.server.board):
                self.wfile.write(event)

    def log_message(self, format: str, *args: Any) -> None:  # noqa: ANN401 -- signature of the library
        """Log nothing."""


def events(board: PublishedTexts) -> Iterator[bytes]:
    """Yield the changes of a board as events of a stream; the kind of an event is the first word of its name."""
    for name, text in board.follow(ALIVE):
        # Texts are JSON in one line, so they cannot contain a line of the protocol.
        yield f"event: {name.split()[0]}\ndata: {text}\n\n".encode() if name else b": alive\n\n"
