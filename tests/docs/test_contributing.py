"""CONTRIBUTING has the map of the house, and the ways to add each kind."""

from benchmarks.figures.rooms import ROOMS, rooms, with_rooms
from tests.paths import ROOT

PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_the_map_names_every_room_as_it_tells_of_itself() -> None:
    assert {found["package"] for found in ROOMS.finditer(PAGE)} == {"stability", "stackdsl"}
    assert with_rooms(PAGE) == PAGE, "write it anew with `python -m benchmarks.figures`"


def test_every_room_tells_of_itself() -> None:
    told = dict([*rooms("stability"), *rooms("stackdsl")])
    assert len(told) > 20
    assert [name for name, text in told.items() if len(text) < 20] == []


def test_there_is_a_way_to_add_each_kind() -> None:
    for kind in ("layout", "claim", "impact", "shape", "system", "engine", "output format", "benchmark"):
        assert f"| a {kind} |" in PAGE or f"| an {kind} |" in PAGE
