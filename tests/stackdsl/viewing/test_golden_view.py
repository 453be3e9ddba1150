"""The view of a golden file marks the differences from the run; a file with other content shows nothing."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from stackdsl.goldens.file_format import canonical_text
from stackdsl.goldens.snapshot import Identity, take
from stackdsl.results import GoldenDifference, GoldenResult, GoldenStatus
from stackdsl.timeline import Arrival
from stackdsl.trace import EventKind
from stackdsl.viewing.golden_view import golden_view
from stackdsl.viewing.replay.page import payload_of
from stackdsl.viewing.run_view import RunView
from tests.stackdsl.viewing.views import SLANT_TOWER, views_of

LEVEL_7 = GoldenDifference("L7.1", "state", "frozen", "fallen", "exact")


@pytest.fixture(scope="module")
def tower() -> RunView:
    (found,) = views_of(SLANT_TOWER)
    return found


@pytest.fixture(scope="module")
def text(tower: RunView) -> str:
    identity = Identity("slant-tower", "exact", "exact")
    return canonical_text(take(tower.trace, tower.timeline.world, identity, {}, modelled=True))


def view(folder: Path, text: str, now: RunView, *differences: GoldenDifference) -> RunView | None:
    file = folder / "exact.json"
    file.write_text(text, encoding="utf-8")
    return golden_view(GoldenResult(GoldenStatus.DIFFERENT, file.as_posix(), differences), now)


def test_a_file_that_a_link_leads_outside_is_not_shown(tmp_path: Path, tower: RunView, text: str) -> None:
    (tmp_path / "golden" / "tower").mkdir(parents=True)
    (tmp_path / "golden" / "tower" / "exact.json").symlink_to("../../exact.json")
    assert view(tmp_path, text, tower) is not None
    told = GoldenResult(GoldenStatus.UNREADABLE, (tmp_path / "golden/tower/exact.json").as_posix())
    assert golden_view(told, tower) is None


def test_bricks_are_where_the_file_has_them_and_fall_when_it_says_so(tmp_path: Path, tower: RunView, text: str) -> None:
    told = json.loads(text)
    told["bricks"]["L1.1"]["at_mm"][0] = 25.0  # it ended 25 mm aside
    seen = view(tmp_path, json.dumps(told), tower, LEVEL_7)
    assert seen is not None
    assert seen.name == "slant-tower[exact], golden file"
    assert seen.verdict == "collapses at level 7; a golden file locks end states and stores no motion"
    assert seen.marks == {"L7.1": ("state: stands, proven in the golden file, fell in this run",)}
    assert tower.trace.collapse is not None
    fell = tower.trace.collapse.time
    before, after = seen.recording.at(fell - 0.1), seen.recording.at(fell + 0.1)
    for number, name in enumerate(seen.recording.names):
        placed = tower.trace.tracks[name].placed
        assert before.positions[number] == pytest.approx(placed.position_W, abs=1e-5), name  # it keeps 0.01 mm
        if name == "L1.1":
            assert after.positions[number] == pytest.approx((0.025, *placed.position_W[1:]), abs=1e-5)
    (collapse,) = [event for event in seen.trace.events if event.kind is EventKind.COLLAPSED]
    assert collapse.time == pytest.approx(fell, abs=1e-3)
    left = {name for name, track in seen.trace.tracks.items() if track.left_at is not None}
    assert left == {name for name, brick in told["bricks"].items() if brick["state"] == "fallen"}
    assert len(left) > 5
    json.dumps(payload_of(seen), allow_nan=False)


def test_a_brick_that_the_run_throws_is_no_part_of_the_structure(tmp_path: Path, tower: RunView, text: str) -> None:
    first, *others = tower.timeline.placements
    timeline = replace(tower.timeline, actions=(replace(first, arrival=Arrival.THROWN), *others))
    seen = view(tmp_path, text, replace(tower, timeline=timeline))
    assert seen is not None
    assert [placement.brick.id for placement in seen.timeline.placements if placement.hits] == [first.brick.id]


def test_turned_bricks_are_turned_the_same_way(tmp_path: Path, tower: RunView, text: str) -> None:
    seen = view(tmp_path, text, tower)
    assert seen is not None
    for name in ("L1.1", "L2.1"):  # levels turn by a quarter
        one, other = seen.trace.tracks[name].placed.orientation, tower.trace.tracks[name].placed.orientation
        assert abs(sum(a * b for a, b in zip(one, other, strict=True))) == pytest.approx(1.0, abs=1e-9)


def placed(told: Any) -> Any:  # noqa: ANN401 -- JSON
    return told["events"][0]["placed"]["L1.1"]


SPOILED: dict[str, Callable[[Any], object]] = {
    "no world": lambda told: told.pop("world"),
    "no place": lambda told: placed(told).pop("at_mm"),
    "a place in words": lambda told: placed(told).update(at_mm="there"),
    "no number": lambda told: placed(told).update(at_mm=[0.0, float("nan"), 0.0]),
    "no size": lambda told: placed(told).update(size_mm=[0.0, 1.0, 1.0]),
    "a time without end": lambda told: told["events"][0].update(time_s=float("inf")),
    "a list of bricks": lambda told: told.update(bricks=[]),
    "twice the same": lambda told: told["events"].append(told["events"][0]),
}


@pytest.mark.parametrize("what", SPOILED)
def test_a_file_that_somebody_spoiled_shows_nothing(tmp_path: Path, tower: RunView, text: str, what: str) -> None:
    told = json.loads(text)
    SPOILED[what](told)
    assert view(tmp_path, json.dumps(told), tower) is None


@pytest.mark.parametrize("text", ["", "[]", "{}", "7", '{"events": 3}', "[" * 100_000])
def test_an_invalid_golden_file_shows_nothing(tmp_path: Path, tower: RunView, text: str) -> None:
    assert view(tmp_path, text, tower) is None
    assert golden_view(GoldenResult(GoldenStatus.MISSING, (tmp_path / "none.json").as_posix()), tower) is None
