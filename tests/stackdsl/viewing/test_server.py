"""Pages are served only to this machine, under a token, and no other file of it is served."""

import http.client
import os
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from stackdsl.viewing.check_report.page import script_and_style
from stackdsl.viewing.replay.page import LOADER, hash_of, program_and_style
from stackdsl.viewing.server import Folder, OnePage, PageServer, PublishedTexts, WebSite, events, listening
from tests.command_line import AMPLE

TOKEN = "a-token-that-nobody-guesses"


class Served:
    """A site that is served from here, and what comes of requests to it."""

    def __init__(self, site: WebSite) -> None:
        self.board = PublishedTexts()
        self.server = PageServer(listening(), TOKEN, site, self.board)
        self.host = "{}:{}".format(*self.server.socket.getsockname())
        threading.Thread(target=self.server.serve_forever, args=(0.01,), daemon=True).start()

    def got(self, path: str, *hosts: str) -> tuple[int, bytes]:
        with closing(http.client.HTTPConnection(self.host, timeout=AMPLE)) as connection:
            connection.putrequest("GET", path, skip_host=True)
            for host in hosts or (self.host,):
                connection.putheader("Host", host)
            connection.endheaders()
            answer = connection.getresponse()
            return answer.status, answer.read()

    def policy(self, path: str) -> str:
        with closing(http.client.HTTPConnection(self.host, timeout=AMPLE)) as connection:
            connection.request("GET", path)
            return connection.getresponse().headers["Content-Security-Policy"]

    def end(self) -> None:
        self.server.shutdown()
        self.server.server_close()


@pytest.fixture
def page() -> Iterator[Served]:
    served = Served(OnePage("<p>tower"))
    yield served
    served.end()


@pytest.fixture
def folder(tmp_path: Path) -> Iterator[Served]:
    (tmp_path / "report" / "replays").mkdir(parents=True)
    (tmp_path / "report" / "index.html").write_text("index", encoding="utf-8")
    (tmp_path / "report" / "replays" / "a=1.html").write_text("replay", encoding="utf-8")
    (tmp_path / "report" / "notes.txt").write_text("notes", encoding="utf-8")
    (tmp_path / "secret.html").write_text("secret", encoding="utf-8")
    (tmp_path / "report" / "link.html").symlink_to(tmp_path / "secret.html")
    os.mkfifo(tmp_path / "report" / "pipe.html")  # reading it would wait for ever
    served = Served(Folder(tmp_path / "report"))
    yield served
    served.end()


def test_the_page_is_there_for_who_knows_the_token(page: Served) -> None:
    assert page.got(f"/{TOKEN}/") == (200, b"<p>tower")
    for path in ("/", f"/{TOKEN}", f"/{TOKEN[:-1]}/", f"/{TOKEN}x/", "//", "/events", f"/x/{TOKEN}/"):
        status, said = page.got(path)
        assert (status, b"tower" in said) == (404, False), path


def test_a_request_with_another_host_name_is_refused(page: Served) -> None:
    port = page.host.split(":")[1]
    assert page.got(f"/{TOKEN}/", f"localhost:{port}")[0] == 200
    for hosts in (["evil.example"], [f"evil.example:{port}"], ["127.0.0.1"], [page.host, "evil.example"], [""]):
        status, said = page.got(f"/{TOKEN}/", *hosts)
        assert (status, b"tower" in said) == (421, False), hosts


def test_the_server_listens_on_the_loopback_interface_alone(page: Served) -> None:
    assert page.server.socket.getsockname()[0] == "127.0.0.1"


def test_pages_of_a_folder_are_served_and_nothing_outside_of_it(folder: Served) -> None:
    assert b"<iframe" in folder.got(f"/{TOKEN}/")[1]
    assert folder.got(f"/{TOKEN}/index.html") == (200, b"index")
    assert folder.got(f"/{TOKEN}/replays/a%3D1.html") == (200, b"replay")
    outside = (
        "../secret.html",
        "%2e%2e/secret.html",
        "replays/../../secret.html",
        "link.html",
        "/etc/hosts",
        "..%2fsecret.html",
    )
    for name in (*outside, "notes.txt", "replays", "pipe.html", "a%00.html", "%ff.html", "x" * 5000 + ".html"):
        status, said = folder.got(f"/{TOKEN}/{name}")
        assert (status, b"secret" in said) == (404, False), name


def test_a_page_of_a_folder_runs_the_scripts_of_reports_alone_whoever_wrote_it(folder: Served) -> None:
    script, _ = script_and_style()
    program, _ = program_and_style()
    for name in ("index.html", "replays/a%3D1.html"):
        policy = folder.policy(f"/{TOKEN}/{name}")
        rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
        assert set(rules["script-src"].split()) == {hash_of(each) for each in (script, program, LOADER)}
        assert (rules["default-src"], rules["frame-ancestors"]) == ("'none'", "'self'")


def test_a_reader_gets_all_there_is_and_then_every_change(page: Served) -> None:
    page.board.put("run 0", '"old"')
    page.board.put("run 0", '"tower"')
    page.board.put("run 1", '"gone"')
    page.board.drop("run 1")
    with closing(http.client.HTTPConnection(page.host, timeout=AMPLE)) as connection:
        connection.request("GET", f"/{TOKEN}/events")
        answer = connection.getresponse()
        assert answer.getheader("Content-Type") == "text/event-stream"
        assert [answer.readline() for _ in range(3)] == [b"event: run\n", b'data: "tower"\n', b"\n"]
        page.board.put("status", "1")
        assert [answer.readline() for _ in range(2)] == [b"event: status\n", b"data: 1\n"]


def test_a_reader_of_what_does_not_change_gets_signs_of_life() -> None:
    board = PublishedTexts()
    news = board.follow(0.001)
    assert next(news) == ("", "")
    board.put("status", "1")
    assert next(news) == ("status", "1")
    stream = events(board)
    assert next(stream) == b"event: status\ndata: 1\n\n"
