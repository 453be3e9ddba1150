"""Records for tests: texts of AT2 files and CSV tables, made up."""

from collections.abc import Sequence
from math import exp, pi
from pathlib import Path

from stackdsl.checking.cases import gather
from stackdsl.diagnostics import Diagnostic
from stackdsl.timeline import Timeline

STANDARD_GRAVITY = 9.80665
BLOCK = "{size: [100 mm, 100 mm, 40 mm], mass: 500 g}"


def at2(accelerations: Sequence[float], step: float, unit: str = "G") -> str:
    """A file as PEER writes it, of accelerations in m/s2 at a time step [s]."""
    words = [f"{acceleration / STANDARD_GRAVITY:15.7E}" for acceleration in accelerations]
    lines = ["".join(words[first : first + 5]) for first in range(0, len(words), 5)]
    head = ["MADE FOR TESTS", "NO EARTHQUAKE, 0 DEG", f"ACCELERATION TIME SERIES IN UNITS OF {unit}"]
    return "\n".join([*head, f"NPTS={len(words):7d}, DT={step:8.4f} SEC", *lines]) + "\n"


def csv(header: str, rows: Sequence[Sequence[float]]) -> str:
    """A table with a line of headers."""
    return "\n".join([header, *(",".join(f"{value:.9g}" for value in row) for row in rows)]) + "\n"


def wavelet(peak: float, step: float = 0.005, count: int = 200) -> list[float]:
    """Ricker's wavelet: a pulse with a weaker one to the other side before and after it [m/s2]."""
    squares = [(pi * (step * number - 0.4) / 0.45) ** 2 for number in range(count)]
    return [peak * (1.0 - 2.0 * square) * exp(-square) for square in squares]


def scene_with(folder: Path, files: dict[str, str], text: str) -> tuple[list[Timeline], list[Diagnostic]]:
    """The timelines and mistakes of a scenario beside files in a folder."""
    for name, content in files.items():
        (folder / name).write_text(content, encoding="utf-8", newline="")
    (folder / "scene.yaml").write_text(text, encoding="utf-8")
    gathered = gather([folder / "scene.yaml"])
    return [case.timeline for case in gathered.cases], list(gathered.diagnostics)


def shaken(folder: Path, files: dict[str, str], shake: str, brick: str = BLOCK, rest: str = "") -> Timeline:
    """The timeline of one brick on ground shaken by files in a folder."""
    text = f"scenario: scene\nbrick: {brick}\nworld: {{shake: {{{shake}}}}}\nbuild: [column: {{levels: 1}}]\n"
    (timeline,), mistakes = scene_with(folder, files, f"{text}{rest}\nexpect: [energy: {{gain: <= 1 %}}]\n")
    assert mistakes == []
    return timeline
