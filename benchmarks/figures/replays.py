"""Pictures of replay pages for docs/seeing.md and the README, drawn by a browser.

Debian's Chromium draws them on the processor. Run it with `python -m benchmarks.figures.replays`.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path
from time import sleep
from typing import Final

from rich.console import Console
from selenium import webdriver
from selenium.webdriver.support.ui import Select, WebDriverWait

from benchmarks.replay import OPTIONS
from stackdsl.checking.cases import gather
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.simulation.recording import Recorder
from stackdsl.viewing.replay.page import replay_page
from stackdsl.viewing.run_view import RunView, view_of

DOCS: Final = Path(__file__).parents[2] / "docs"
SHOWN: Final = Path("scenarios/slant-tower.yaml")
SYSTEMS: Final = ("exact", "thesis")
SCREEN: Final = {"width": 1280, "height": 860, "deviceScaleFactor": 1, "mobile": False}
SETTLED: Final = 1.0  # [s] until the camera is where it was sent, and the picture is drawn finely
LONGEST: Final = 60.0  # [s] timeout for opening a page
PRESS: Final = "[...document.querySelectorAll('button')].find(b => b.textContent === arguments[0]).click()"


def main() -> None:
    """Write all pictures."""
    options = webdriver.ChromeOptions()
    for option in OPTIONS:
        options.add_argument(option)
    browser = webdriver.Chrome(options=options)
    try:
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "replay.html"
            page.write_text(replay_page(runs(), "slant-tower"), encoding="utf-8")
            for name, steps in PICTURES.items():
                browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", SCREEN)
                browser.get(page.as_uri())
                WebDriverWait(browser, LONGEST).until(lambda each: each.execute_script("return window.replay"))
                steps(browser)
                browser.execute_script("document.activeElement.blur()")
                sleep(SETTLED)
                browser.save_screenshot(str(DOCS / name))
                Console().print(f"wrote docs/{name}")
    finally:
        browser.quit()


def runs() -> list[RunView]:
    """Return the recorded runs of the slant tower on each system."""
    cases = [case for case in gather([SHOWN]).cases if case.scenario.scenario == SHOWN.stem]
    found = []
    for system in SYSTEMS:
        case = next(each for each in cases if each.system == system)
        recorder = Recorder()
        trace = play_case(case.timeline, case.system, recorder=recorder)
        found.append(view_of(case, trace, recorder.recording(), judged(case, trace)))
    return found


def forces(browser: webdriver.Chrome) -> None:
    """Show the tower before its fall, with the contact forces that prove that it stands."""
    browser.execute_script("replay.seek(12.9)")
    for button in ("Fit", "Forces"):
        browser.execute_script(PRESS, button)


def beside(browser: webdriver.Chrome) -> None:
    """Show two systems side by side, some time after the fall."""
    _choose(browser, "thesis")
    browser.execute_script("replay.seek(14.2)")


def motion(browser: webdriver.Chrome) -> None:
    """Show the motion that proves the fall, from the front."""
    _choose(browser, "Front")
    browser.execute_script("replay.seek(13.0)")
    for button in ("Parallel", "Motion"):
        browser.execute_script(PRESS, button)


def _choose(browser: webdriver.Chrome, text: str) -> None:
    """Choose a text in the last list that has it."""
    for found in reversed(browser.find_elements("css selector", "select")):
        for each in found.find_elements("css selector", "option"):
            if text in each.text:
                Select(found).select_by_visible_text(each.text)
                return


PICTURES: Final[dict[str, Callable[[webdriver.Chrome], None]]] = {
    "replay-forces.png": forces,
    "replay-beside.png": beside,
    "replay-motion.png": motion,
}

if __name__ == "__main__":
    main()
