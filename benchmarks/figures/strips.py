"""The scenes of the publication as strips of pictures, in docs/pictures; `make pictures`, a minute.

Each strip shows the case of a page from before the first motion to the end, or the building of a case without motion.
"""

import re
from pathlib import Path
from typing import Final, NamedTuple

from rich.console import Console
from rich.progress import track

from benchmarks.figures.pages import ROOT
from stackdsl.checking.cases import Case, gather
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.simulation.recording import Recorder
from stackdsl.viewing.drawing import VIEWS
from stackdsl.viewing.pictures import building, heading_at, heading_of, panels_at, picture, strip
from stackdsl.viewing.run_view import view_of

FOLDER: Final = ROOT / "docs" / "pictures"


class Strip(NamedTuple):
    """One case, and its display."""

    file: str
    case: str
    view: str = "three-quarter"
    panels: int = 6
    built: bool = False  # whether it shows the building rather than the motion at the end

    @property
    def path(self) -> Path:
        """Return the path of its file."""
        return FOLDER / f"{re.sub(r'[^A-Za-z0-9.]+', '-', self.case).rstrip('-')}.svg"


STRIPS: Final = (
    Strip("capabilities/four-stack.yaml", "capabilities-four-stack[thesis]"),
    Strip("capabilities/four-stack.yaml", "capabilities-four-stack-stock[stock]", "front", built=True),
    Strip("capabilities/card-house.yaml", "capabilities-card-house[thesis]", "front"),
    Strip("capabilities/slant-tower.yaml", "capabilities-slant-tower[exact]", "front"),
    Strip("capabilities/slant-tower.yaml", "capabilities-slant-tower[thesis]", "front"),
    Strip("capabilities/impact-top.yaml", "capabilities-impact-top-fast[exact]", "side"),
    Strip("capabilities/impact-top.yaml", "capabilities-impact-top-thesis[speed=1m/s,thesis]", "side"),
    Strip("capabilities/impact-level-3.yaml", "capabilities-impact-level-3-hard[exact]", "side"),
    Strip("capabilities/impact-level-3.yaml", "capabilities-impact-level-3-thesis[speed=2m/s,thesis]", "side"),
    Strip("user_test/leaning-structure.yaml", "user-test-leaning-structure[exact]", "front"),
    Strip("user_test/card-house.yaml", "user-test-card-house[exact]", "front"),
    Strip("user_test/card-house.yaml", "user-test-card-house[thesis]", "front"),
    Strip("user_test/three-left-of-one.yaml", "user-test-three-left-of-one[exact]", "front"),
    Strip("user_test/wrong-configurations.yaml", "user-test-three-on-one-side[exact]", "front"),
    Strip("user_test/wrong-configurations.yaml", "user-test-held-by-one-that-leans-away[exact]"),
)


def main() -> None:
    """Play and draw."""
    FOLDER.mkdir(exist_ok=True)
    for one in track(STRIPS, description="strips", console=Console(stderr=True)):
        one.path.write_text(drawn(one), encoding="utf-8")


def case_of(one: Strip) -> Case:
    """Return the case of a strip."""
    return next(case for case in gather([ROOT / "scenarios" / one.file]).cases if case.name == one.case)


def drawn(one: Strip) -> str:
    """Return a strip as SVG."""
    case, recorder = case_of(one), Recorder()
    trace = play_case(case.timeline, case.system, recorder=recorder)
    run = view_of(case, trace, recorder.recording(), judged(case, trace))
    view = VIEWS[one.view]
    if one.panels == 1:
        end = trace.cost.simulated_time
        return picture(run, heading_at(run, end), panels_at([view], end))
    panels = building if one.built else strip
    return picture(run, heading_of(run, view), panels(run, view, one.panels))


if __name__ == "__main__":
    main()
