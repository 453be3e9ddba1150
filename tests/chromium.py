"""A real browser, without a network: Debian's Chromium through its own driver, one for all tests."""

import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

BROWSER, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
QUIET = (
    "--headless=new",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1200,800",
    "--disable-gpu-compositing",  # without a graphics card, half of the time of a frame
    "--enable-unsafe-swiftshader",
    "--use-angle=swiftshader",
)
NO_NETWORK = "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"  # this machine is no network
LONGEST = 60.0  # [s] that a page may take on a machine that does much else


# Texts that are cut off: beyond the window, or beyond a part that hides what does not fit. What scrolls can be read.
CUT = """
const cut = [], wide = document.documentElement.clientWidth;
const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
for (let node; (node = walk.nextNode());) {
  const parent = node.parentElement;
  const unseen = ['SCRIPT', 'STYLE', 'NOSCRIPT', 'OPTION'].includes(parent.tagName) || !parent.checkVisibility();
  if (!node.data.trim() || unseen) continue;
  const range = document.createRange(); range.selectNodeContents(node);
  for (const box of range.getClientRects()) {
    if (!box.width) continue;
    let scrolls = false;
    for (let on = parent; on && on !== document.body; on = on.parentElement) {
      const style = getComputedStyle(on), edge = on.getBoundingClientRect();
      scrolls ||= /auto|scroll/.test(style.overflowX + style.overflowY);
      const over = box.right > edge.right + 1 || box.bottom > edge.bottom + 1;
      if (style.overflowX === 'hidden' && !scrolls && over) cut.push(node.data);
    }
    const closed = box.right <= 0;  // a drawer aside of the window
    if (!scrolls && !closed && (box.left < -1 || box.right > wide + 1)) cut.push(node.data);
  }
}
if (document.documentElement.scrollWidth > wide) cut.push('the page is wider than the window');
return cut
"""
# The page draws as ever, but what draws puts nothing on the canvas.
NOTHING_DRAWN = """
for (const name of ['drawArrays', 'drawElements', 'drawElementsInstanced'])
  WebGL2RenderingContext.prototype[name] = () => undefined;
"""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run the tests of the browser in one process, so that it starts once."""
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.xdist_group("chromium"))


@pytest.fixture(scope="session")
def started_browser() -> Iterator["Chrome"]:
    """The browser; the test is skipped where there is none."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="needs selenium")
    if BROWSER is None or DRIVER is None:
        pytest.skip("needs chromium and chromedriver")
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for each in (*QUIET, NO_NETWORK):
        options.add_argument(each)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    try:
        yield driver
    finally:
        driver.quit()


@pytest.fixture
def browser(started_browser: "Chrome") -> Iterator["Chrome"]:
    """The browser on an empty page, of its usual size and in light colours."""
    yield started_browser
    started_browser.get("about:blank")  # the page of a test may still ask its server
    started_browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    started_browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    complaints(started_browser)


@pytest.fixture
def undrawn(browser: "Chrome") -> Iterator["Chrome"]:
    """The browser, in which WebGL draws nothing: without a graphics card, each picture takes a tenth of a second."""
    script = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": NOTHING_DRAWN})
    yield browser
    browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)


def opened(browser: "Chrome", page: Path) -> None:
    """Open a page, and wait until it plays."""
    browser.get(page.as_uri())
    wait_for(lambda: browser.execute_script("return window.replay !== undefined"))


def resize(browser: "Chrome", width: int, height: int, dark: bool = False, still: bool = False) -> None:
    screen = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    wanted = {"prefers-color-scheme": "dark" if dark else "light", "prefers-reduced-motion": "reduce" if still else ""}
    features = [{"name": name, "value": value} for name, value in wanted.items()]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    settle(browser)


def settle(browser: "Chrome") -> None:
    """Wait for frames in which the page has seen its new size, and said all that changed."""
    browser.execute_async_script(
        "const done = arguments[0]; let left = 4;"
        "const frame = () => left-- ? requestAnimationFrame(frame) : done(); frame()"
    )


def complaints(browser: "Chrome") -> list[str]:
    """Return the new messages in the console of the browser, without warnings that software draws slowly."""
    messages = [str(entry["message"]) for entry in browser.get_log("browser")]  # type: ignore[no-untyped-call]
    return [message for message in messages if "GPU stall due to ReadPixels" not in message]


def wait_for(holds: Callable[[], object]) -> None:
    """Wait until something holds; a page that is still being built may lack the element that is asked for."""
    not_yet = pytest.importorskip("selenium.common.exceptions").JavascriptException
    until, met = time.monotonic() + LONGEST, None
    while time.monotonic() < until:
        try:
            if holds():
                return
        except not_yet as error:
            met = error
        time.sleep(0.05)
    raise AssertionError("nothing happened") from met
