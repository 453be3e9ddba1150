"""What differs waits until somebody accepts it or not; nothing is accepted unseen, and nothing is lost."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from random import Random

import pytest

from tests.command_line import GOOD, Stackdsl, write
from tests.paths import ROOT

MOVED = GOOD.replace("{levels: 3}", "{levels: 3, origin: [5 mm, 0 mm, 0 mm]}")
FAILING = MOVED + "  - height: 20 mm ± 1 mm\n"


@pytest.fixture
def locked(stackdsl: Stackdsl, tmp_path: Path) -> Path:
    """A project with one scenario that is locked; and the file of that."""
    write(tmp_path, GOOD, "scenarios/good.yaml")
    assert stackdsl("check").code == 0
    return tmp_path / "golden" / "good" / "exact.json"


def change(folder: Path, text: str) -> None:
    write(folder, text, "scenarios/good.yaml")


def test_a_difference_waits_is_accepted_and_then_the_same(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    was = locked.read_text()
    change(tmp_path, MOVED)
    assert stackdsl("check").code == 3
    status = stackdsl("golden", "status")
    assert (status.code, "different: good[exact]: golden/good/exact.json: 6 differences" in status.out) == (3, True)
    assert locked.read_text() == was
    assert stackdsl("golden", "accept").code == 0
    assert locked.read_text() != was
    assert stackdsl("check", CI="true").code == 0
    assert stackdsl("golden", "status").out.strip() == "0 pending; stackdsl check compares with the golden files"


def test_a_case_that_is_named_without_an_option_is_answered_by_the_option(stackdsl: Stackdsl) -> None:
    for word, option in [("books", "-k books "), ("scenarios/books.yaml", "-k books "), ("a b", "-k 'a b' ")]:
        refused = stackdsl("golden", "accept", word)
        assert (refused.code, option in refused.err) == (4, True)


def test_a_name_of_no_pending_case_is_answered_by_the_pending_ones(
    stackdsl: Stackdsl, tmp_path: Path, locked: Path
) -> None:
    for command in ("accept", "reject", "review"):
        assert (
            stackdsl("golden", command, "-k", "bad").out == "0 pending; stackdsl check compares with the golden files\n"
        )
    change(tmp_path, MOVED)
    stackdsl("check")
    refused = stackdsl("golden", "accept", "-k", "bad")
    assert (refused.code, "'bad' in its name; pending: good[exact]" in refused.err) == (4, True)


def test_a_golden_that_agrees_again_is_no_longer_pending(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    stackdsl("check")
    change(tmp_path, MOVED)
    stackdsl("check")
    change(tmp_path, GOOD)
    assert "1 remembered" in stackdsl("check").out
    assert stackdsl("golden", "status").code == 0


def test_a_rename_that_was_taken_back_takes_no_golden_file_away(
    stackdsl: Stackdsl, tmp_path: Path, locked: Path
) -> None:
    change(tmp_path, GOOD.replace("good", "better"))
    stackdsl("check")
    change(tmp_path, GOOD)
    stackdsl("check")
    stackdsl("golden", "accept")
    assert locked.exists()


def test_a_renamed_case_is_not_accepted_under_its_old_name(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    was = locked.read_text()
    change(tmp_path, MOVED)
    stackdsl("check")
    change(tmp_path, MOVED.replace("good", "better"))
    refused = stackdsl("golden", "accept")
    assert (refused.code, locked.read_text()) == (3, was)
    assert "scenarios/good.yaml has no case good[exact] any more" in refused.err
    assert "has no case good[exact]" in stackdsl("golden", "status").out
    assert "has no case good[exact]" in stackdsl("golden", "review", keys="a").err
    assert locked.read_text() == was
    assert stackdsl("check").code == 3  # the old golden file is obsolete
    assert stackdsl("golden", "status").out.strip() == "0 pending; stackdsl check compares with the golden files"


def test_a_known_failure_is_accepted_without_accept_failing(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    change(tmp_path, FAILING + "xfail: it is to be 20 mm high one day\n")
    assert stackdsl("check").code == 3
    assert stackdsl("golden", "accept").code == 0


def test_a_rejected_difference_leaves_the_golden_file(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    was = locked.read_text()
    change(tmp_path, MOVED)
    stackdsl("check")
    assert "is unchanged" in stackdsl("golden", "reject").out
    assert (locked.read_text(), stackdsl("golden", "status").code) == (was, 0)


def test_a_review_shows_brick_quantity_was_and_is_and_takes_one_key(
    stackdsl: Stackdsl, tmp_path: Path, locked: Path
) -> None:
    change(tmp_path, MOVED)
    stackdsl("check")
    seen = stackdsl("golden", "review", keys="s")
    (row,) = [line for line in seen.out.splitlines() if "when placed" in line]
    assert "L1.1, L2.1, L3.1: 0.00 mm -> 5.00 mm" in row
    assert (seen.code, stackdsl("golden", "review", keys="q").code) == (3, 3)
    assert stackdsl("golden", "review", keys="a").code == 0
    assert stackdsl("check", CI="true").code == 0


def test_a_review_gives_the_largest_of_many_changes_and_with_v_that_of_every_brick(
    stackdsl: Stackdsl, tmp_path: Path, locked: Path
) -> None:
    change(tmp_path, GOOD.replace("levels: 3", "levels: 5, step: 0 mm"))
    stackdsl("check", "--update")
    change(tmp_path, GOOD.replace("levels: 3", "levels: 5, step: 4 mm"))
    stackdsl("check")
    assert "by up to 16 mm (L5.1: 0.00 mm -> 16.00 mm)" in stackdsl("golden", "review", keys="q").out
    every = stackdsl("golden", "review", "-v", keys="q").out
    assert [f"L{n}.1: 0.00 mm -> {4 * (n - 1)}.00 mm" in every for n in (2, 3, 4, 5)] == [True] * 4


def test_a_failing_case_is_accepted_only_with_accept_failing(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    was = locked.read_text()
    change(tmp_path, FAILING)
    assert stackdsl("check").code == 1
    refused = stackdsl("golden", "accept")
    assert (refused.code, "--accept-failing" in refused.err, locked.read_text()) == (3, True, was)
    assert "press A to accept it anyway" in stackdsl("golden", "review", keys="aq").err
    assert locked.read_text() == was
    assert stackdsl("golden", "review", keys="A").code == 0
    assert locked.read_text() != was


def test_a_golden_that_changed_since_the_review_is_not_accepted(
    stackdsl: Stackdsl, tmp_path: Path, locked: Path
) -> None:
    change(tmp_path, MOVED)
    stackdsl("check")
    locked.write_text(locked.read_text().replace('"format"', ' "format"'))
    refused = stackdsl("golden", "accept")
    assert (refused.code, "check good[exact] again" in refused.err) == (3, True)


def test_a_rename_is_seen_as_one(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    was = json.loads(locked.read_text())
    change(tmp_path, GOOD.replace("good", "better"))
    told = stackdsl("check")
    assert told.code == 3
    assert "golden/better/exact.json: renamed: it was golden/good/exact.json" in told.out
    assert "obsolete" not in told.out
    assert "was golden/good/exact.json" in stackdsl("golden", "accept").out
    assert not locked.exists()
    assert json.loads((tmp_path / "golden" / "better" / "exact.json").read_text()) == {**was, "scenario": "better"}
    assert stackdsl("check", CI="true").code == 0


@pytest.mark.parametrize(
    ("golden", "renamed_from"),
    [
        ("golden/../../outside.json", ""),
        ("golden/a/exact.json", "precious"),
        ("golden/a/exact.json", "golden/../precious"),
    ],
)
def test_a_forged_pending_change_writes_and_removes_no_other_file(
    stackdsl: Stackdsl, tmp_path: Path, locked: Path, golden: str, renamed_from: str
) -> None:
    precious = write(tmp_path, "precious", "precious")
    change(tmp_path, MOVED)
    stackdsl("check")
    (file,) = (tmp_path / ".stackdsl" / "pending").iterdir()
    forged = {"golden": golden, "renamed_from": renamed_from, "against": ""}
    file.write_text(json.dumps({**json.loads(file.read_text()), **forged}))
    stackdsl("golden", "accept")
    assert (precious.exists(), (tmp_path.parent / "outside.json").exists()) == (True, False)


def test_another_scene_under_another_name_is_no_rename(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    change(tmp_path, MOVED.replace("good", "better"))
    told = stackdsl("check")
    assert (told.code, "renamed" in told.out, "obsolete" in told.out) == (3, False, True)
    assert "golden/better/exact.json: new" in told.out
    assert stackdsl("golden", "prune", "--dry-run").out == "obsolete: golden/good/exact.json\n"
    assert stackdsl("golden", "prune").out == "removed: golden/good/exact.json\n"
    assert stackdsl("check").code == 0


def test_nothing_is_pruned_while_a_scenario_has_a_mistake(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    change(tmp_path, GOOD.replace("levels", "levles"))
    assert stackdsl("golden", "prune").code == 2
    assert locked.exists()


def test_the_markers_of_a_merge_are_called_so(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    text = locked.read_text()
    locked.write_text(f"<<<<<<< ours\n{text}=======\n{text}>>>>>>> theirs\n")
    told = stackdsl("check")
    assert (told.code, "a merge conflict at line 1" in told.out) == (3, True)
    assert stackdsl("golden", "accept").code == 0
    assert locked.read_text() == text


def test_an_input_that_moves_less_than_a_result_may_is_told(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    change(tmp_path, GOOD.replace("{levels: 3}", "{levels: 3, origin: [0.4 mm, 0 mm, 0 mm]}"))
    told = stackdsl("check")
    assert (told.code, "x when placed" in told.out) == (3, True)


def test_nothing_is_accepted_in_ci(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    change(tmp_path, MOVED)
    stackdsl("check", CI="true")
    assert stackdsl("golden", "status").code == 0  # and nothing waits that nobody could see
    assert stackdsl("golden", "accept", CI="true").code == 4


ACCEPTING = """
import sys
from pathlib import Path
from stackdsl.goldens.golden import PendingStore
waiting = PendingStore(Path(sys.argv[1]))
print("ready", flush=True)
for pending in waiting.all():
    waiting.accept(pending)
"""


def accepting(folder: Path) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "CI": ""}
    command = [sys.executable, "-c", ACCEPTING, str(folder / ".stackdsl")]
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)


def fifty_waiting(folder: Path) -> dict[Path, tuple[str, str]]:
    """Fifty golden files, each with what it is and what it would become."""
    texts = {}
    for number in range(50):
        golden = folder / "golden" / f"case-{number}" / "exact.json"
        golden.parent.mkdir(parents=True, exist_ok=True)
        head = {"format": 1, "scenario": f"case-{number}", "variant": "exact", "system": "exact"}
        old, new = (json.dumps({**head, "verdict": age + "x" * 20_000}) for age in ("old", "new"))
        golden.write_text(old)
        texts[golden] = old, new
    return texts


def offer(folder: Path, texts: dict[Path, tuple[str, str]]) -> None:
    from stackdsl.goldens.golden import PendingStore, text_digest  # noqa: PLC0415 -- as the next
    from stackdsl.results import GoldenResult, GoldenStatus  # noqa: PLC0415 -- as the next

    for golden, (old, new) in texts.items():
        digest = text_digest(old.encode())
        result = GoldenResult(GoldenStatus.DIFFERENT, golden.as_posix(), digest=digest, offered=new)
        PendingStore(folder / ".stackdsl").note(f"{golden.parent.name}[exact]", result, ())


@pytest.mark.parametrize("kills", [3, pytest.param(200, marks=pytest.mark.slow)])
def test_accepting_that_is_killed_at_any_instant_leaves_every_golden_whole(tmp_path: Path, kills: int) -> None:
    texts, random, midway = fifty_waiting(tmp_path), Random(7), 0
    for _ in range(kills):
        for golden, (old, _) in texts.items():
            golden.write_text(old)
        offer(tmp_path, texts)
        process = accepting(tmp_path)
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(random.uniform(0.0, 0.15))
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        found = {golden: golden.read_text() for golden in texts}
        assert all(found[golden] in texts[golden] for golden in texts)
        midway += 0 < sum(found[golden] == texts[golden][1] for golden in texts) < len(texts)
    process = accepting(tmp_path)  # what is left is accepted by the next call
    process.communicate()
    assert all(golden.read_text() == new for golden, (_, new) in texts.items())
    assert midway > 0 or kills < 200  # some were cut short indeed


def test_two_that_accept_at_once_lose_nothing(tmp_path: Path) -> None:
    texts = fifty_waiting(tmp_path)
    offer(tmp_path, texts)
    both = [accepting(tmp_path), accepting(tmp_path)]
    for process in both:
        process.communicate()
    assert all(golden.read_text() == new for golden, (_, new) in texts.items())
    assert [process.returncode for process in both] == [0, 0]


def test_an_accepted_rename_leaves_no_empty_directory(stackdsl: Stackdsl, tmp_path: Path, locked: Path) -> None:
    was = GOOD.partition("scenario: ")[2].partition("\n")[0]
    change(tmp_path, GOOD.replace(f"scenario: {was}", "scenario: better", 1))
    assert "renamed" in stackdsl("check").out
    assert stackdsl("golden", "accept").code == 0
    assert [folder.name for folder in (tmp_path / "golden").iterdir()] == ["better"]
    assert not locked.exists()


@pytest.mark.parametrize(
    ("written", "meant"), [("list", "did you mean 'status'?"), ("acept", "did you mean 'accept'?")]
)
def test_an_unknown_golden_command_is_answered_by_the_one_that_is_meant(
    stackdsl: Stackdsl, written: str, meant: str
) -> None:
    refused = stackdsl("golden", written)
    assert (refused.code, meant in refused.err) == (4, True)
