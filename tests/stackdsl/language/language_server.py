"""Runs yaml-language-server as a process, with the requests of an editor."""

import json
import os
import shutil
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tests.paths import ROOT

INSTALLED = ROOT / ".node" / "node_modules" / ".bin" / "yaml-language-server"  # by `make editor`
AT_HAND = shutil.which("yaml-language-server") or (str(INSTALLED) if INSTALLED.exists() else "")


class LanguageServer:
    """A running server, with one document at a time."""

    def __init__(self, process: "subprocess.Popen[bytes]", folder: Path) -> None:
        self._process, self._folder, self._asked, self._opened = process, folder, 0, 0
        self.mistakes: Sequence[Mapping[str, Any]] | None = None  # of the document, once it has been looked through

    def ask(self, method: str, parameters: object) -> Any:  # noqa: ANN401 -- JSON
        """Send a request and return the response."""
        self._asked += 1
        self._send({"id": self._asked, "method": method, "params": parameters})
        while True:
            message = self._received()
            if message.get("id") == self._asked and "method" not in message:
                return message.get("result")

    def tell(self, method: str, parameters: object) -> None:
        """Send a notification, which has no response."""
        self._send({"method": method, "params": parameters})

    def open(self, text: str) -> None:
        """Open a new document, and wait for its diagnostics."""
        self._opened, self.mistakes = self._opened + 1, None
        document = {"uri": self._uri, "languageId": "yaml", "version": 1, "text": text}
        self.tell("textDocument/didOpen", {"textDocument": document})
        while self.mistakes is None:
            self._received()

    def completions(self, line: int, column: int) -> set[str]:
        """Return the completions at a place, counted from 0."""
        place = {"textDocument": {"uri": self._uri}, "position": {"line": line, "character": column}}
        return {item["label"] for item in self.ask("textDocument/completion", place)["items"]}

    def hover(self, line: int, column: int) -> str:
        """Return the hover text at a place."""
        place = {"textDocument": {"uri": self._uri}, "position": {"line": line, "character": column}}
        return str(self.ask("textDocument/hover", place)["contents"]["value"])

    @property
    def _uri(self) -> str:
        return (self._folder / f"scenario-{self._opened}.yaml").as_uri()

    def _send(self, message: dict[str, object]) -> None:
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        assert self._process.stdin is not None
        self._process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self._process.stdin.flush()

    def _received(self) -> Mapping[str, Any]:
        """Return the next message; answer requests of the server by null."""
        assert self._process.stdout is not None
        length = 0
        while line := self._process.stdout.readline().strip():
            name, _, value = line.partition(b":")
            length = int(value) if name.lower() == b"content-length" else length
        message: Mapping[str, Any] = json.loads(self._process.stdout.read(length))
        told_of = message.get("params", {}).get("uri") if isinstance(message.get("params"), dict) else None
        if message.get("method") == "textDocument/publishDiagnostics" and told_of == self._uri:
            self.mistakes = message["params"]["diagnostics"]
        elif "method" in message and "id" in message:
            wanted = len(message["params"].get("items", [])) if message["method"] == "workspace/configuration" else 0
            self._send({"id": message["id"], "result": [None] * wanted if wanted else None})
        return message


@contextmanager
def serving(folder: Path) -> Iterator[LanguageServer]:
    """Start a server for a document in a folder."""
    command = ["node", os.path.realpath(AT_HAND), "--stdio"]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, cwd=folder
    ) as process:
        try:
            server = LanguageServer(process, folder)
            server.ask("initialize", {"processId": None, "rootUri": folder.as_uri(), "capabilities": {}})
            server.tell("initialized", {})
            yield server
        finally:
            process.kill()
