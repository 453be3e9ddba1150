"""The golden file of very many bricks is short, and yet names the brick that differs."""

import json
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import pytest

from stackdsl.goldens.comparison import compare_documents
from stackdsl.goldens.file_format import canonical_text, document
from stackdsl.goldens.golden import check_golden
from stackdsl.goldens.short_format import MANY, golden_text, shortened
from stackdsl.goldens.snapshot import COMPACT_FORMAT, UNCLEAR, FinalBrick, PlacedBrick, Placing, Snapshot
from stackdsl.results import GoldenDifference, GoldenStatus
from tests.paths import ROOT
from tests.stackdsl.goldens.changes import STANDS
from tests.stackdsl.goldens.test_golden_files import place

PILES = 16
LEVELS = 70

Document: TypeAlias = dict[str, Any]


def piles(levels: int = LEVELS) -> Snapshot:
    """Sixteen piles of planks that stand apart, built level by level."""
    events: list[Placing] = []
    bricks: dict[str, FinalBrick] = {}
    for level in range(1, levels + 1):
        for pile in range(1, PILES + 1):
            at = (250.0 * pile, 0.0, 7.8 * level - 3.9)
            below = {f"L{level - 1}.{pile}": 1.0} if level > 1 else {"ground": 1.0}
            made = PlacedBrick(at, (0.0, 0.0, 0.0), (117.6, 23.4, 7.8), 11.95564, below)
            events.append(Placing(float(len(events)), None, {f"L{level}.{pile}": made}))
            bricks[f"L{level}.{pile}"] = FinalBrick(level, "frozen", at, below)
    return replace(STANDS, events=tuple(events), bricks=bricks)


STANDING = piles()
IN_FULL: Document = json.loads(json.dumps(document(STANDING)))
SHORT: Document = json.loads(golden_text(STANDING))


def differences(change: Callable[[Document], object]) -> list[GoldenDifference]:
    """Of a run that came out otherwise, from the file."""
    run = deepcopy(IN_FULL)
    change(run)
    return list(compare_documents(SHORT, run))


def event_of(run: Document, brick: str) -> Document:
    return next(event for event in run["events"] if brick in event["placed"])


def test_a_run_agrees_with_its_own_file() -> None:
    assert SHORT["format"] == COMPACT_FORMAT
    assert differences(lambda run: None) == []


def test_up_to_a_thousand_bricks_are_told_in_full() -> None:
    few = piles(MANY // PILES)
    assert golden_text(few) == canonical_text(few)


def test_what_a_plank_takes_in_the_file_is_below_ten_characters() -> None:
    more = piles(2 * LEVELS)
    assert (len(golden_text(more)) - len(golden_text(STANDING))) / (PILES * LEVELS) < 10


def test_the_tower_of_11200_planks_takes_less_than_100_kb() -> None:
    assert (ROOT / "golden" / "record-tower" / "exact.json").stat().st_size < 100_000


def test_a_plank_that_is_placed_1_mm_beside_is_named() -> None:
    def shift(run: Document) -> None:
        event_of(run, "L57.3")["placed"]["L57.3"]["at_mm"][0] += 1.0
        run["bricks"]["L57.3"]["at_mm"][0] += 1.0

    (found,) = differences(shift)
    assert (found.subject, found.quantity) == ("L57.3", "how it is placed, and on what")
    assert "placed at (751.0, 0.0, 440.7) mm" in found.got


def test_a_plank_that_moved_by_1_mm_is_named_with_both_places() -> None:
    (found,) = differences(lambda run: run["bricks"]["L57.3"]["at_mm"].__setitem__(0, 751.0))
    assert (found.subject, found.quantity, found.expected, found.got) == ("L57.3", "x", "750.00 mm", "751.00 mm")


def test_a_plank_that_moved_by_less_than_the_tolerance_agrees() -> None:
    assert differences(lambda run: run["bricks"]["L57.3"]["at_mm"].__setitem__(0, 750.4)) == []


@pytest.mark.parametrize(
    ("change", "subject", "quantity"),
    [
        (lambda run: run["bricks"]["L9.2"].update(state="fallen"), "L9.2", "state"),
        (lambda run: run["bricks"]["L9.2"]["rests_on"].update({"L8.2": 0.9}), "L9.2", "share on L8.2"),
        (lambda run: run["bricks"]["L9.2"].update(rests_on={"L8.3": 1.0}), "L9.2", "how it is placed, and on what"),
        (lambda run: event_of(run, "L9.2").update(time_s=1e4), "L9.2", "how it is placed, and on what"),
        (lambda run: event_of(run, "L9.2").update(margin_mm=3.0), "event 130 (129.000 s)", "margin"),
        (
            lambda run: event_of(run, "L9.2")["placed"]["L9.2"].update(mass_g=12.0),
            "L9.2",
            "how it is placed, and on what",
        ),
        (lambda run: run.update(height_mm=3.0), "structure", "height"),
        (lambda run: run["world"].update(friction=0.4), "world", "friction"),
    ],
)
def test_whatever_differs_of_a_plank_it_is_named(
    change: Callable[[Document], object], subject: str, quantity: str
) -> None:
    (found,) = differences(change)
    assert (found.subject, found.quantity) == (subject, quantity)


def test_a_plank_that_is_gone_is_told_by_its_level_and_one_that_is_new_by_its_name() -> None:
    def rename(run: Document) -> None:
        event = event_of(run, "L9.2")
        event["placed"]["new"] = event["placed"].pop("L9.2")
        run["bricks"]["new"] = run["bricks"].pop("L9.2")

    def remove(run: Document) -> None:
        run["events"].remove(event_of(run, "L9.2"))
        del run["bricks"]["L9.2"]

    assert [found.subject for found in differences(rename)] == ["new"]
    (gone,) = differences(remove)
    assert (gone.subject, gone.quantity, gone.expected, gone.got) == ("level 9", "bricks", "16", "15")


def test_two_planks_whose_marks_are_alike_by_chance_are_told_apart_by_the_digest() -> None:
    #   The marks are 18 bits long; the digest of all is not.
    forged = {**SHORT, "sha256": "0" * 64}
    (found,) = compare_documents(forged, IN_FULL)
    assert (found.subject, found.quantity) == ("structure", "how bricks are placed, and on what")


def test_what_ended_elsewhere_and_what_is_unclear_are_kept() -> None:
    run = deepcopy(IN_FULL)
    run["bricks"]["L9.2"]["at_mm"] = [510.0, 0.0, 66.3]
    run["bricks"]["L9.3"]["state"] = UNCLEAR
    del run["bricks"]["L9.3"]["at_mm"]
    short = json.loads(json.dumps(shortened(run)))
    assert list(short["bricks"]) == ["L9.2"]
    assert list(compare_documents(short, run)) == []
    back = deepcopy(run)
    back["bricks"]["L9.2"]["at_mm"] = [500.0, 0.0, 66.3]
    (found,) = compare_documents(short, back)
    assert (found.subject, found.quantity, found.expected) == ("L9.2", "x", "510.00 mm")
    back = deepcopy(run)
    back["bricks"]["L9.3"]["state"] = "frozen"
    assert list(compare_documents(short, back)) == []  # what was too close to call agrees with any way to end


def test_a_file_in_full_is_still_read_and_written_in_short_by_an_update(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CI", raising=False)  # CI writes no golden
    file = place(tmp_path)
    file.parent.mkdir(exist_ok=True, parents=True)
    file.write_text(canonical_text(STANDING), encoding="ascii")
    assert check_golden(STANDING, tmp_path, update=False).status is GoldenStatus.SAME
    assert check_golden(STANDING, tmp_path, update=True).status is GoldenStatus.WRITTEN
    assert file.read_text(encoding="ascii") == golden_text(STANDING)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda file: file["levels"]["9"].update(bricks="many"), "marks of level 9"),
        (lambda file: file["levels"]["9"].update(marks="abc"), "marks of level 9"),
        (lambda file: file["levels"]["9"].update(wrong=1), "level 9 has an unknown key 'wrong'"),
        (lambda file: file["levels"]["9"].update(ends=[[3, "frozen"]]), "does not speak of 16 bricks"),
        (lambda file: file["levels"]["9"].update(ends=[3]), "not a list of pairs"),
        (lambda file: file.update(levels=[]), "'levels' is not an object"),
    ],
)
def test_a_short_file_that_somebody_broke_says_where(
    change: Callable[[Document], object], words: str, tmp_path: Path
) -> None:
    broken = deepcopy(SHORT)
    change(broken)
    file = place(tmp_path)
    file.parent.mkdir(exist_ok=True, parents=True)
    file.write_text(json.dumps(broken), encoding="ascii")
    result = check_golden(STANDING, tmp_path, update=False)
    assert result.status is GoldenStatus.UNREADABLE
    assert words in result.note
