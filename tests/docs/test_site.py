"""The site of the documentation in a real browser, as `make docs` built it."""

from typing import TYPE_CHECKING

import pytest

from tests.chromium import CUT, complaints, resize, wait_for
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
    "docs/physics",
    "docs/api",
    "docs/api/stability.Assembly",
    "docs/api/stackdsl.api.layouts",
    "docs/choose",
    "docs/formats",
    "docs/units",
    "docs/columns",
    "docs/glossary",
    "search",
)
# The contrast of up to 300 texts to what is painted below them, by the formula of WCAG 2.2: those below 4.5.
FAINT = """
const part = c => (c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
const light = c => 0.2126 * part(c[0]) + 0.7152 * part(c[1]) + 0.0722 * part(c[2]);
const pen = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
const rgba = text => {  // any notation of a colour
  pen.clearRect(0, 0, 1, 1); pen.fillStyle = text; pen.fillRect(0, 0, 1, 1);
  const [r, g, b, a] = pen.getImageData(0, 0, 1, 1).data; return [r, g, b, a / 255];
};
const over = (top, below) => [0, 1, 2].map(i => top[3] * top[i] + (1 - top[3]) * below[i]).concat(1);
const ground = element => {
  const painted = [];
  for (let on = element; on; on = on.parentElement) painted.push(rgba(getComputedStyle(on).backgroundColor));
  return painted.reduceRight((below, top) => over(top, below), [255, 255, 255, 1]);
};
const shown = [...document.querySelectorAll('body *')].filter(e => e.checkVisibility({visibilityProperty: true}) &&
  !e.closest('svg, iframe, noscript, script, style') && [...e.childNodes].some(n => n.nodeType === 3 && n.data.trim()));
const every = Math.max(1, Math.floor(shown.length / 300));
return shown.filter((_, at) => at % every === 0).map(e => {
  const below = ground(e), [a, b] = [light(over(rgba(getComputedStyle(e).color), below)), light(below)];
  return [e.textContent.trim().slice(0, 40), (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05)];
}).filter(([, ratio]) => ratio < 4.5);
"""
LOADED = "return performance.getEntriesByType('resource').map(e => e.name)"
THERE = "return document.URL === arguments[0] && document.readyState === 'complete'"
TERMS = "return [...document.querySelectorAll('a.term')].map(a => [a.textContent, a.href, a.title])"

pytestmark = pytest.mark.skipif(not (SITE / "index.html").exists(), reason="`make docs` builds the site first")


def show(browser: "Chrome", page: str) -> None:
    """Open a page, and wait until it is there: on a busy machine, the driver may answer for the page before it."""
    address = (SITE / f"{page}.html").as_uri()
    browser.get(address)
    wait_for(lambda: browser.execute_script(THERE, address))


@pytest.mark.parametrize("page", PAGES)
def test_a_page_of_the_site_asks_for_nothing_elsewhere_and_can_be_read_at_all_sizes(
    browser: "Chrome", page: str
) -> None:
    show(browser, page)
    assert [name for name in browser.execute_script(LOADED) if not name.startswith("file:")] == []
    for dark in (False, True):
        for width in (1280, 420):
            resize(browser, width, 900, dark)
            assert browser.execute_script(CUT) == [], (width, dark)
            assert browser.execute_script(FAINT) == [], (width, dark)
    assert complaints(browser) == []


def test_the_columns_of_a_page_fit_into_windows_of_any_width(browser: "Chrome") -> None:
    show(browser, "docs/tutorial")
    for width in (700, 1000, 1080, 1320, 1500, 1920):
        resize(browser, width, 900)
        assert browser.execute_script(CUT) == [], width


def test_every_scene_of_the_gallery_can_be_played(browser: "Chrome") -> None:
    show(browser, "docs/gallery")
    links = browser.execute_script("return [...document.querySelectorAll('a.replay')].map(a => a.href)")
    assert len(links) == 23
    browser.get(links[0])
    assert browser.execute_script("return document.title")


def test_a_term_links_to_its_definition_at_its_first_use(browser: "Chrome") -> None:
    show(browser, "docs/physics")
    terms = {text.lower(): (link, told) for text, link, told in browser.execute_script(TERMS)}
    assert "with the smallest set of moving bricks" in terms["mechanisms"][1]
    browser.get(terms["mechanisms"][0])
    assert browser.execute_script("return document.querySelector(':target td').textContent") == "mechanism"
    assert len({link for link, _ in terms.values()}) == len(terms), "only the first use of a term is a link"
    assert not {"limits", "table"} & terms.keys(), "words of every day are no terms unless they are emphasized"


def cells(browser: "Chrome") -> list[str]:
    return list(browser.execute_script("return [...document.querySelectorAll('article td')].map(td => td.textContent)"))


def test_a_class_has_a_page_of_its_own_with_a_list_of_its_members(browser: "Chrome") -> None:
    show(browser, "docs/api")
    browser.execute_script("arguments[0].click()", browser.find_element("link text", "Assembly"))
    wait_for(lambda: browser.current_url.endswith("/stability.Assembly.html") and cells(browser))
    rows = cells(browser)
    told = dict(zip(rows[::2], rows[1::2], strict=True))
    assert told["add"] == "Set down one brick at rest and return the verdict on all bricks."
    assert {"verdict", "forces", "remove"} <= told.keys()
