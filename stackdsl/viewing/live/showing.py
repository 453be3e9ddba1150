"""The server as whoever plays runs sees it: a process of its own, so that a run that takes long keeps no page waiting.

And so that who plays has no threads: only of such a process are copies safe, which start in a hundredth of a second.
"""

import json
import multiprocessing
import os
import signal
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection
from secrets import token_urlsafe

from stackdsl.exits import INTERRUPTS
from stackdsl.viewing.live.board import Board
from stackdsl.viewing.live.server import HOST, PageServer, listening
from stackdsl.viewing.live.sites import Site

TOKEN_BYTES = 24  # 192 bits


@dataclass(frozen=True)
class Showing:
    """A site that is served."""

    url: str
    _connection: Connection

    def put(self, name: str, value: object) -> None:
        """Show a value, as JSON, under a name. Raises OSError if the server is gone."""
        self.put_text(name, json.dumps(value, allow_nan=False))

    def put_text(self, name: str, text: str) -> None:
        """Show JSON in one line under a name. Raises OSError if the server is gone."""
        self._connection.send((name, text))

    def drop(self, name: str) -> None:
        """Show nothing under a name any more. Raises OSError if the server is gone."""
        self._connection.send((name, None))


@contextmanager
def showing(site: Site) -> Iterator[Showing]:
    """Serve a site until the end of the block. Raises OSError if no port of this machine can be had."""
    token = token_urlsafe(TOKEN_BYTES)
    with listening() as listener:
        ours, theirs = multiprocessing.Pipe()
        url = f"http://{HOST}:{listener.getsockname()[1]}/{token}/"
        context = multiprocessing.get_context("fork")
        process = context.Process(target=_serve, args=(listener, token, site, theirs, ours), daemon=True)
        process.start()
        theirs.close()
    try:
        yield Showing(url, ours)
    finally:
        process.kill()
        process.join()
        ours.close()


def _serve(listener: socket.socket, token: str, site: Site, told: Connection, others: Connection) -> None:
    """What the process does, until nobody tells it anything any more."""
    for number in INTERRUPTS:  # whoever started it decides what they mean
        signal.signal(number, signal.SIG_IGN)
    others.close()
    board = Board()
    server = PageServer(listener, token, site, board)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        while True:
            name, text = told.recv()
            if text is None:
                board.drop(name)
            else:
                board.put(name, text)
    except (EOFError, OSError):
        os._exit(0)  # threads that wait for browsers would keep it
