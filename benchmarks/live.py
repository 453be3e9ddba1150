"""Measures the delay of a live page: from saving a file to the frame that shows its verdict and smallest clearance.

A tower of a hundred planks is saved with another step, again and again, under `stackdsl run --watch`, each time after
the previous run has been played. Debian's Chromium shows it, without a graphics card.

Run: python -m benchmarks.live [--write]
"""

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from time import sleep, time
from typing import Final

from rich.console import Console
from rich.progress import track
from rich.table import Table
from selenium import webdriver

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.replay import OPTIONS

STACK: Final = """
scenario: tower
build:
  - four_stack: {{levels: 50, step: {step}, spacing: 43 mm}}
    every: 1 s
systems: [exact]
expect: [{{stands: all}}]
"""
SCENES: Final = {
    "100 planks that stand": ("0.2 mm", "0.3 mm"),
    "100 planks that stand by each other's weight": ("1 mm", "0.9 mm"),
    "100 planks that fall at level 13": ("6 mm", "6.1 mm"),
    "100 planks that fall at level 35": ("2 mm", "2.01 mm"),
}
TURNS: Final = 5
PATIENCE: Final = 120.0  # [s]
PLAYED: Final = "window.replay && replay.drawn() && !document.querySelector('h1').textContent.includes('is running')"
WAIT: Final = """
const heard = replay.heard();
let drawn = replay.drawn();
window.seen = 0;
const look = () => {
  if (replay.heard() === heard) drawn = replay.drawn();
  if (replay.heard() > heard && replay.drawn() > drawn) window.seen = Date.now();
  else requestAnimationFrame(look);
};
requestAnimationFrame(look);
"""


def main() -> None:
    """Measure and print the table; write it on request."""
    arguments = parser(__doc__).parse_args()
    rows = {name: measured(*SCENES[name]) for name in track(SCENES, console=Console(stderr=True))}
    table = Table("scene", "median [ms]", "worst [ms]", "of the processor, without the browser [ms]")
    for name, row in rows.items():
        table.add_row(name, *(f"{row[key]:.0f}" for key in ("median_ms", "worst_ms", "processor_ms")))
    Console().print(table)
    if arguments.write:
        record("live", "python -m benchmarks.live --write", {"scenes": rows})


def measured(*steps: str) -> Row:
    """Return the times from the save of each step to the frame that shows it."""
    seen: list[float] = []
    processor_times: list[float] = []
    with tempfile.TemporaryDirectory() as folder, browser() as page:
        file = Path(folder) / "tower.yaml"
        file.write_text(STACK.format(step="0.5 mm"), encoding="utf-8")
        with served(file) as (process, url):
            page.get(url)
            for turn in range(TURNS):
                wait(page, PLAYED)
                page.execute_script(WAIT)
                before, began = processor_ms(process), time()
                file.write_text(STACK.format(step=steps[turn % len(steps)]), encoding="utf-8")
                wait(page, "window.seen")
                processor_times.append(processor_ms(process) - before)
                seen.append(page.execute_script("return window.seen") - 1000.0 * began)
    return {"median_ms": median(seen), "worst_ms": max(seen), "processor_ms": min(processor_times)}


def wait(page: webdriver.Chrome, until: str) -> None:
    """Wait for a condition in a page, with few checks, which would affect the measured time."""
    began = time()
    while not page.execute_script(f"return {until}"):
        if time() - began > PATIENCE:
            raise TimeoutError(until)
        sleep(0.25)


def processor_ms(process: int) -> float:
    """Return the processor time of a single process [ms]."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return 1000.0 * (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def served(file: Path) -> Iterator[tuple[int, str]]:
    """Run the command on a watched file; yield its process id and the address of its page."""
    command = [sys.executable, "-m", "stackdsl", "run", "--watch", str(file)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            address = re.search(r"http://\S+", process.stderr.readline())
            assert address is not None
            yield process.pid, address[0]
        finally:
            process.kill()


@contextmanager
def browser() -> Iterator[webdriver.Chrome]:
    """Chromium without a window."""
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for each in OPTIONS:
        options.add_argument(each)
    chromium = webdriver.Chrome(options=options, service=webdriver.ChromeService("/usr/bin/chromedriver"))
    try:
        yield chromium
    finally:
        chromium.quit()


if __name__ == "__main__":
    main()
