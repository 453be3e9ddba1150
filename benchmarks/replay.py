"""Measures the size of a replay page, the time to its first frame, and its frame rate without a graphics card.

Planks stand as a four-stack, and those at the top tumble: each on its own path, with a random displacement of a tenth
of a millimetre at every sample, which is harder to compress than a fall from an engine. Debian's Chromium draws the
pages on the processor.

Run: python -m benchmarks.replay [--write]
"""

import os
import tempfile
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from time import monotonic, sleep
from typing import Final

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track
from rich.table import Table
from selenium import webdriver

from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from stackdsl.checking.cases import cases_of
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.language.yaml.source import parse
from stackdsl.simulation.recording import COLUMNS, ORIENTATION, POSITION, TIME, Recorder
from stackdsl.viewing.replay.page import replay_page
from stackdsl.viewing.run_view import RunView, view_of

STACK: Final = """
scenario: four-stack
build:
  - four_stack: {{levels: {levels}}}
systems: [exact]
expect: [{{stands: all}}]
"""
FRAMES: Final = """
const done = arguments[arguments.length - 1];
let count = 0; const began = performance.now();
dispatchEvent(new KeyboardEvent('keydown', {key: 'Home'}));
dispatchEvent(new KeyboardEvent('keydown', {key: ' '}));
const frame = () => { count++; if (performance.now() - began > 2000) done([count, (performance.now() - began) / 1000]);
  else requestAnimationFrame(frame); };
requestAnimationFrame(frame);
"""
# Like a browser without a graphics card: WebGL by SwiftShader, and no GPU compositing.
OPTIONS: Final = ("--headless=new", "--no-sandbox", "--disable-background-networking", "--enable-unsafe-swiftshader",
                  "--window-size=1200,800")  # fmt: skip


@dataclass(frozen=True, slots=True)
class Scene:
    """Displayed scene."""

    planks: int
    falling: int
    frames: int


TRIES: Final = 3
BEST: Final = {"first_frame_s": min, "frames_per_second": max, "processor_ms": min}
SCENES: Final = (Scene(200, 200, 250), Scene(1000, 100, 200), Scene(11_200, 500, 120))


def main() -> None:
    """Measure and print the table; write it on request."""
    arguments = parser(__doc__).parse_args()
    bar = Console(stderr=True)
    rows = {_name(scene): measured(scene) for scene in track(SCENES, description="replays", console=bar)}
    table = Table("scene", "MB", "first frame [s]", "frames a second", "of a processor [ms a frame]")
    for name, row in rows.items():
        table.add_row(
            name, *(f"{row[key]:.3g}" for key in ("page_mb", "first_frame_s", "frames_per_second", "processor_ms"))
        )
    Console().print(table)
    if arguments.write:
        record("replay", "python -m benchmarks.replay --write", {"scenes": rows})


def _name(scene: Scene) -> str:
    return f"{scene.planks:,} planks, {scene.falling} of which tumble for {scene.frames} frames"


def measured(scene: Scene) -> Row:
    """Return size, time to the first frame and frame rate of one scene: the best of some tries on a busy machine."""
    page = replay_page([view(scene)], "replay").encode()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "replay.html"
        file.write_bytes(page)
        shown = [_shown(file) for _ in range(TRIES)]
    best = {key: BEST[key](each[key] for each in shown) for key in BEST}
    return {"page_mb": len(page) / 1e6, **best}


def view(scene: Scene) -> RunView:
    """Return the standing planks with a recording in which those at the top tumble."""
    ((case,), _) = cases_of(parse(STACK.format(levels=scene.planks // 2), "scene.yaml"))
    recorder = Recorder()
    trace = play_case(case.timeline, case.system, recorder=recorder)
    recording = recorder.recording()
    still = recording.keys[: scene.planks - scene.falling]
    keys = np.concatenate((still, tumbling(recording.keys[scene.planks - scene.falling :], scene.frames)))
    seen = view_of(case, trace, replace(recording, keys=keys), judged(case, trace))
    cost = replace(trace.cost, simulated_time=scene.frames / 60.0)
    return replace(seen, trace=replace(trace, cost=cost))


def tumbling(rows: NDArray[np.float64], frames: int) -> NDArray[np.float64]:
    """Return `frames` rows per row of a brick, in which each brick flies and rotates on its own path."""
    random, count = np.random.default_rng(7), len(rows)
    keys = np.repeat(rows[:, None, :], frames, axis=1)
    times = np.arange(frames) / 60.0
    keys[..., TIME] = times
    keys[..., POSITION] += random.normal(0.0, 0.5, (count, 1, 3)) * times[None, :, None]
    keys[..., POSITION] += random.normal(0.0, 1e-4, (count, frames, 3))
    angle = random.normal(0.0, 5.0, (count, 1)) * times + random.normal(0.0, 2e-3, (count, frames))
    axis = random.normal(0.0, 1.0, (count, 1, 3))
    axis /= np.linalg.norm(axis, axis=2, keepdims=True)
    keys[..., ORIENTATION] = np.concatenate((axis * np.sin(angle / 2.0)[..., None], np.cos(angle / 2.0)[..., None]), 2)
    return keys.reshape(-1, COLUMNS)


def processor_time(parent: int) -> float:
    """Return the processor time of a process and of all its descendants so far [s]."""
    parents, times = {}, {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            fields = stat.read_text().rpartition(")")[2].split()
            parents[int(stat.parent.name)] = int(fields[1])
            times[int(stat.parent.name)] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    family = {parent}
    while more := {one for one, of in parents.items() if of in family} - family:
        family |= more
    return sum(times.get(one, 0.0) for one in family)


def _shown(file: Path) -> dict[str, float]:
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for each in OPTIONS:
        options.add_argument(each)
    browser = webdriver.Chrome(options=options, service=webdriver.ChromeService("/usr/bin/chromedriver"))
    try:
        browser.set_script_timeout(60)
        began = monotonic()
        browser.get(file.as_uri())
        while not browser.execute_script("return window.replay !== undefined && replay.drawn() > 0"):
            sleep(0.01)
        first = monotonic() - began
        before = processor_time(browser.service.process.pid)
        count, seconds = browser.execute_async_script(FRAMES)
        took = processor_time(browser.service.process.pid) - before
        return {"first_frame_s": first, "frames_per_second": count / seconds, "processor_ms": 1000.0 * took / count}
    finally:
        browser.quit()


if __name__ == "__main__":
    main()
