"""Serves a site to browsers of this machine, and tells them of changes as events (Server-Sent Events).

The standard library does: one page, one stream of texts and a handful of readers need no framework, and nothing more to
install. It listens on the loopback interface alone, knows only addresses that begin with a token that nobody can guess,
and answers only who calls it by the name of this machine: a foreign page, whose name somebody lets point here (DNS
rebinding), gets nothing. No request changes anything.
"""

import hmac
import socket
from collections.abc import Iterator
from contextlib import suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Final
from urllib.parse import unquote, urlsplit

from stackdsl.viewing.live.board import Board
from stackdsl.viewing.live.sites import EVENTS, Site

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

    def __init__(self, listener: socket.socket, token: str, site: Site, board: Board) -> None:
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
