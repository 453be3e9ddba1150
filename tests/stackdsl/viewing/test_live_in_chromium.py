"""A live page in a real browser: what is saved is seen, and a mistake is told as text beside the last good picture."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from stackdsl.checking.cases import cases_of
from stackdsl.language.yaml.source import parse
from stackdsl.results import Report
from stackdsl.viewing.check_report.page import index_page
from stackdsl.viewing.live import RunPage, margined, mistake_json, played, preview, showing
from stackdsl.viewing.replay.page import live_page, page_of
from stackdsl.viewing.server import Folder, OnePage
from tests.chromium import CUT, complaints, resize, wait_for
from tests.stackdsl.viewing.test_check_report import result
from tests.stackdsl.viewing.test_replay_in_chromium import SIZES

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

COLUMN = """\
scenario: leaning
build:
  - column: {{levels: {levels}, step: 12 mm}}
    every: 1 s
systems: [exact]
expect: [{{stands: all}}]
"""


def preview_of(levels: int) -> str:
    (case,), _ = cases_of(parse(COLUMN.format(levels=levels), "scene.yaml"))
    return preview(case)


def text_of(page: "Chrome", place: str) -> str:
    return str(page.execute_script(f"return document.querySelector({json.dumps(place)}).textContent"))


@contextmanager
def live_page_of_a_standing_column(browser: "Chrome", levels: int = 5) -> Iterator[RunPage]:
    """Open the live page of a column of planks that is proven to stand; one of five slides before it tips."""
    with showing(OnePage(live_page("scene.yaml"))) as served:
        page = RunPage(served)
        page.expect(1)
        saved(page, levels)
        browser.get(served.url)
        wait_for(lambda: "Proven to stand" in text_of(browser, "h1"))
        yield page


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
        wait_for(lambda: browser.find_element("css selector", "#search").is_displayed())
        browser.get(f"{served.url}replay.html")
        wait_for(lambda: browser.find_elements("css selector", "h1"))
        wait_for(lambda: "Proven to stand" in text_of(browser, "h1"))
        assert complaints(browser) == []
        browser.get(f"{served.url}theirs.html")
        assert browser.title == "as sent"
        assert any("Content Security Policy" in each for each in complaints(browser))


def saved(page: RunPage, levels: int) -> None:
    page.show_file(COLUMN.format(levels=levels))
    page.show(0, preview_of(levels))


def mistake_in(text: str) -> Mapping[str, Any]:
    _, mistakes = cases_of(parse(text, "scene.yaml"))
    return mistake_json(mistakes[0])


def test_the_page_shows_what_is_saved_and_keeps_it_beside_a_mistake(browser: "Chrome") -> None:
    with showing(OnePage(live_page("scene.yaml"))) as served:
        page = RunPage(served)
        page.expect(1)
        page.show_activity("playing")
        saved(page, 5)
        browser.get(served.url)
        wait_for(lambda: "Proven to stand" in text_of(browser, "h1"))
        wait_for(lambda: "L5.1, with its centre of mass 10.8 mm inside" in text_of(browser, ".band"))
        assert "playing" in text_of(browser, ".state")
        there = pytest.approx([0.048, 0.0, 0.0351], abs=1e-4)
        wait_for(lambda: browser.execute_script("return replay.positionOf('L5.1')") == there)
        saved(page, 12)
        wait_for(lambda: "Proven to fall" in text_of(browser, "h1"))
        wait_for(lambda: browser.execute_script("return replay.time()") == pytest.approx(9.0))
        page.note(0, ["<b>it would survive</b>"])
        wait_for(lambda: "<b>it would survive</b>" in text_of(browser, ".facts"))
        hostile = "<img src=x onerror=alert(1)> </script> \x1b[31m is no length"
        page.show_mistakes([mistake_json(hostile)])
        wait_for(lambda: text_of(browser, ".mistakes") == hostile)
        assert browser.execute_script("return document.querySelectorAll('img').length") == 0
        page.expect(2)
        page.show(1, preview_of(3))
        wait_for(lambda: browser.execute_script("return document.querySelectorAll('.runs option').length") == 5)
        page.show_mistakes([])
        wait_for(lambda: "Proven to fall" in text_of(browser, "h1"))
        assert complaints(browser) == []
    wait_for(lambda: "stackdsl has ended" in text_of(browser, "h1"))
    assert "Still showing the last run" in text_of(browser, ".lead")


def test_the_weakest_brick_is_told_once_its_margins_are_known(
    browser: "Chrome", monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.nice", lambda more: more)
    (case,), _ = cases_of(parse(COLUMN.format(levels=8), "scene.yaml"))
    weakest = "[...document.querySelectorAll('button')].find(b => b.textContent === 'Weakest')"
    with live_page_of_a_standing_column(browser, 8) as page:
        assert browser.execute_script(f"return {weakest}.disabled && !{weakest}.hidden")
        margins = margined(case)
        page.note(0, margins.lines, margins.weakest)
        wait_for(lambda: "Weakest above " in text_of(browser, ".lead"))
        page.show(0, played(case).json)
        wait_for(lambda: "Passed" in text_of(browser, "h1"))
        assert "tip over ground" in text_of(browser, ".lead")
        browser.execute_script(f"{weakest}.click()")
        wait_for(lambda: text_of(browser, ".inspector h2") == "L1.1")
        assert not browser.execute_script("return document.querySelector(`option[value='weakest']`).hidden")
        assert complaints(browser) == []


def test_a_file_that_cannot_be_read_is_told_with_its_line_above_the_last_picture(browser: "Chrome") -> None:
    text = COLUMN.format(levels=5).replace("step:", "stp:")
    with live_page_of_a_standing_column(browser) as page:
        page.show_file(text, [mistake_in(text)])
        wait_for(lambda: text_of(browser, "h1") == "Cannot read scene.yaml: unknown key 'stp'")
        assert "Still showing the last file that could be read." in text_of(browser, ".lead")
        assert "did you mean 'step'?" in text_of(browser, ".lead")
        assert text_of(browser, ".excerpt .wrong").strip() == "- column: {levels: 5, stp: 12 mm}"
        assert "^^^" in text_of(browser, ".mistakes")
        assert browser.execute_script("return replay.positionOf('L5.1').length") == 3
        saved(page, 4)
        wait_for(lambda: text_of(browser, ".state") == "valid")
        assert browser.execute_script("return document.querySelectorAll('.excerpt .wrong').length") == 0


def test_a_fall_is_told_with_its_cause_and_a_first_remedy_to_copy(
    browser: "Chrome", monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("os.nice", lambda more: more)
    text = COLUMN.format(levels=12)
    (case,), _ = cases_of(parse(text, "scene.yaml"))
    with showing(OnePage(live_page("scene.yaml"))) as served:
        page = RunPage(served)
        page.expect(1)
        page.show_file(text)
        page.show(0, played(case).json)
        margins = margined(case)
        page.note(0, margins.lines, margins.weakest, margins.helps)
        browser.get(served.url)
        wait_for(lambda: "Would help" in text_of(browser, ".lead"))
        assert text_of(browser, "h1").startswith("Failed: stands: expected all, measured ")
        assert "tip over" in text_of(browser, ".lead")
        assert "step ≤ 9.8 mm, now 12 mm, line 3" in text_of(browser, ".lead").replace("\xa0", " ")
        tall = browser.execute_script("return document.querySelector('.lead').getBoundingClientRect().height")
        assert tall <= 2 * 24  # the rest is folded
        assert not browser.execute_script("return document.querySelector('details').open")
        assert "stands: all" in text_of(browser, ".excerpt .failing")
        for width, height in SIZES:
            resize(browser, width, height, dark=width < 1000)
            assert browser.execute_script(CUT) == [], (width, height)
        assert complaints(browser) == []
