"""The map of rooms in CONTRIBUTING."""

from benchmarks.figures.rooms import ROOMS, with_rooms
from tests.paths import ROOT

PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_the_map_names_every_room_as_it_tells_of_itself() -> None:
    assert {found["package"] for found in ROOMS.finditer(PAGE)} == {"stability", "stackdsl"}
    assert with_rooms(PAGE) == PAGE, "write it anew with `python -m benchmarks.figures`"
