"""The report of a check in a real browser: all cases without any script, and with it a choice of them."""

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from stackdsl.results import Report
from stackdsl.viewing.check_report.page import index_page
from tests.chromium import CUT, complaints, resize
from tests.stackdsl.viewing.test_check_report import result

if TYPE_CHECKING:
    from selenium.webdriver import Chrome


@pytest.fixture
def index(tmp_path: Path) -> str:
    file = tmp_path / "index.html"
    file.write_text(index_page(Report((result("tower"), result("wall", -1.0))), {}, {}), encoding="utf-8")
    return file.as_uri()


def shown(browser: "Chrome", place: str) -> list[bool]:
    return [element.is_displayed() for element in browser.find_elements("css selector", place)]


ROWS = ".row > summary"


def test_without_a_script_all_cases_are_shown_and_nothing_that_does_nothing(browser: "Chrome", index: str) -> None:
    browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        browser.get(index)
        assert shown(browser, ROWS) == [True, True]
        assert shown(browser, ".tools") == [False]
    finally:
        browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})


def test_failures_are_shown_first_and_the_rest_by_a_button_or_a_word(browser: "Chrome", index: str) -> None:
    browser.get(index)
    assert shown(browser, ROWS) == [True, False]  # the wall, which failed, and the tower
    browser.find_element("css selector", "[data-status=passed]").click()
    assert shown(browser, ROWS) == [True, True]
    browser.find_element("id", "search").send_keys("TOWER")
    assert shown(browser, ROWS) == [False, True]
    browser.find_element("id", "search").send_keys("s of nothing")
    assert shown(browser, ROWS) == [False, False]
    browser.find_element("id", "reset").click()
    assert shown(browser, ROWS) == [True, True]
    assert complaints(browser) == []


@pytest.mark.parametrize("width", [1280, 420])
def test_nothing_is_cut_off_or_asked_for_elsewhere(browser: "Chrome", index: str, width: int) -> None:
    resize(browser, width, 900)
    browser.get(index)
    browser.find_element("css selector", "[data-status=passed]").click()
    assert browser.execute_script(CUT) == []
    assert browser.execute_script("return performance.getEntriesByType('resource').length") == 0
