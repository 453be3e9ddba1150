"""The site of the documentation in a real browser, as `make docs` built it."""

from typing import TYPE_CHECKING

import pytest

from tests.chromium import CUT, resize
from tests.paths import ROOT

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

SITE = ROOT / "build" / "site"
PAGES = (
    "index",
    "docs/tutorial",
    "docs/gallery",
    "docs/guides/pallets",
    "docs/language",
    "docs/command",
    "docs/api",
    "docs/choose",
    "docs/units",
    "docs/columns",
    "search",
)
pytestmark = pytest.mark.skipif(not (SITE / "index.html").exists(), reason="`make docs` builds the site first")


@pytest.mark.parametrize("width", [1280, 420])
@pytest.mark.parametrize("page", PAGES)
def test_a_page_of_the_site_asks_for_nothing_elsewhere_and_cuts_nothing_off(
    browser: "Chrome", page: str, width: int
) -> None:
    resize(browser, width, 900)
    browser.get((SITE / f"{page}.html").as_uri())
    loaded = browser.execute_script("return performance.getEntriesByType('resource').map(e => e.name)")
    assert [name for name in loaded if not name.startswith("file:")] == []
    assert browser.execute_script(CUT) == []
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []  # type: ignore[no-untyped-call]


def test_every_scene_of_the_gallery_can_be_played(browser: "Chrome") -> None:
    browser.get((SITE / "docs" / "gallery.html").as_uri())
    links = browser.execute_script("return [...document.querySelectorAll('a.replay')].map(a => a.href)")
    assert len(links) == 20
    browser.get(links[0])
    assert browser.execute_script("return document.title")
