"""A live page in a real browser: what is saved is seen, and a mistake is told as text beside the last good picture."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from stackdsl.checking.cases import cases_of
from stackdsl.language.yaml.source import parse
from stackdsl.results import Report
from stackdsl.viewing.check_report.page import index_page
from stackdsl.viewing.live import RunPage, preview, showing
from stackdsl.viewing.replay.page import live_page, page_of
from stackdsl.viewing.server import Folder, OnePage
from tests.stackdsl.viewing.chromium import chromium, wait_for
from tests.stackdsl.viewing.test_check_report import result

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

pytestmark = pytest.mark.xdist_group("chromium")

COLUMN = """\
scenario: leaning
build:
  - column: {{levels: {levels}, step: 12 mm}}
    every: 1 s
systems: [exact]
expect: [{{stands: all}}]
"""


@pytest.fixture(scope="module")
def browser() -> Iterator["Chrome"]:
    with chromium() as found:
        yield found


def preview_of(levels: int) -> str:
    (case,), _ = cases_of(parse(COLUMN.format(levels=levels), "scene.yaml"))
    return preview(case)


def text_of(page: "Chrome", place: str) -> str:
    return str(page.execute_script(f"return document.querySelector({json.dumps(place)}).textContent"))


def test_a_served_folder_runs_its_report_and_no_script_of_who_sent_it(browser: "Chrome", tmp_path: Path) -> None:
    report = Report((result("tower"), result("wall", -1.0)))
    (tmp_path / "index.html").write_text(index_page(report, {}, {}), encoding="utf-8")
    (case,), _ = cases_of(parse(COLUMN.format(levels=3), "scene.yaml"))
    (tmp_path / "replay.html").write_text(page_of([preview(case)], "scene.yaml"), encoding="utf-8")
    foreign = "<title>as sent</title><body onload='document.title=1'><script>document.title='it ran'</script>"
    (tmp_path / "theirs.html").write_text(foreign, encoding="utf-8")
    with showing(Folder(tmp_path)) as served:
        browser.get(served.url)
        browser.switch_to.frame(0)
        wait_for(lambda: browser.find_element("css selector", ".filter").is_displayed())
        browser.get(f"{served.url}replay.html")
        wait_for(lambda: "proven to stand" in text_of(browser, "h1"))
        assert browser.get_log("browser") == []  # type: ignore[no-untyped-call]
        browser.get(f"{served.url}theirs.html")
        assert browser.title == "as sent"
        assert any("Content Security Policy" in str(each) for each in browser.get_log("browser"))  # type: ignore[no-untyped-call]


def test_the_page_shows_what_is_saved_and_keeps_it_beside_a_mistake(browser: "Chrome") -> None:
    with showing(OnePage(live_page("scene.yaml"))) as served:
        page = RunPage(served)
        page.expect(1)
        page.show_activity("playing")
        page.show(0, preview_of(5))
        browser.get(served.url)
        wait_for(lambda: "proven to stand" in text_of(browser, "h1"))
        wait_for(lambda: "least room: L5.1, whose centre is 10.8 mm inside" in text_of(browser, ".notes"))
        there = pytest.approx([0.048, 0.0, 0.0351], abs=1e-4)
        wait_for(lambda: browser.execute_script("return replay.positionOf('L5.1')") == there)
        page.show(0, preview_of(12))
        wait_for(lambda: "proven to fall" in text_of(browser, "h1"))
        wait_for(lambda: browser.execute_script("return replay.time()") == pytest.approx(9.0))
        mistake = "<img src=x onerror=alert(1)> </script> \x1b[31m is no length"
        page.show_mistakes([mistake])
        page.note(0, ["<b>it would survive</b>"])
        wait_for(lambda: text_of(browser, ".mistakes") == mistake)
        wait_for(lambda: "<b>it would survive</b>" in text_of(browser, ".notes"))
        assert "proven to fall" in text_of(browser, "h1")
        assert browser.execute_script("return document.querySelectorAll('img, b').length") == 0
        page.expect(2)
        page.show(1, preview_of(3))
        wait_for(lambda: browser.execute_script("return document.querySelectorAll('header option').length") == 5)
        page.show_mistakes([])
        wait_for(lambda: text_of(browser, ".mistakes") == "")
        assert browser.get_log("browser") == []  # type: ignore[no-untyped-call]
    wait_for(lambda: "stackdsl has ended" in text_of(browser, ".state"))
