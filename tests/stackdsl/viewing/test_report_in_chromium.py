"""The report of a check in a real browser: a table without any script, and one that can be filtered with it."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from stackdsl.results import Report
from stackdsl.viewing.check_report.page import index_page
from tests.stackdsl.viewing.chromium import chromium
from tests.stackdsl.viewing.test_check_report import result

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

pytestmark = pytest.mark.xdist_group("chromium")


@pytest.fixture(scope="module")
def browser() -> Iterator["Chrome"]:
    with chromium() as found:
        yield found


@pytest.fixture
def index(tmp_path: Path) -> str:
    file = tmp_path / "index.html"
    file.write_text(index_page(Report((result("tower"), result("wall", -1.0))), {}, {}), encoding="utf-8")
    return file.as_uri()


def shown(browser: "Chrome", place: str) -> list[bool]:
    return [element.is_displayed() for element in browser.find_elements("css selector", place)]


def test_without_a_script_there_is_the_table_and_nothing_that_does_nothing(browser: "Chrome", index: str) -> None:
    browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        browser.get(index)
        assert shown(browser, "#cases tbody tr") == [True, True]
        assert shown(browser, ".filter") == [False]
    finally:
        browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})


def test_with_it_words_and_failures_can_be_looked_for(browser: "Chrome", index: str) -> None:
    browser.get(index)
    assert shown(browser, ".filter") == [True]
    browser.find_element("id", "search").send_keys("TOWER")
    assert shown(browser, "#cases tbody tr") == [False, True]  # what failed comes first
    browser.find_element("id", "only").click()
    assert shown(browser, "#cases tbody tr") == [False, False]
    browser.find_element("id", "search").send_keys("\ue003" * len("TOWER"))  # the key that takes a letter back
    assert shown(browser, "#cases tbody tr") == [True, False]
    assert browser.get_log("browser") == []  # type: ignore[no-untyped-call]
