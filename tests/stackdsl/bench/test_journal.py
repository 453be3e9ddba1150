"""The journal of a bench: what is done survives a stop, and what is not wanted is put aside."""

from dataclasses import replace
from pathlib import Path

import pytest

from stackdsl.bench.journal import Journal
from stackdsl.bench.run_record import MalformedRecordError, TruthHeld, line_of, record_of
from tests.stackdsl.bench.runs import FELL, RECORD, run


def test_a_record_survives_its_line() -> None:
    record = replace(run(FELL), truths=(TruthHeld("height", "mm", None, False),), message="x\ny")
    assert record_of(line_of(record)) == record
    assert "\n" not in line_of(record)


@pytest.mark.parametrize("line", ["", "{", "[]", "{}", line_of(RECORD)[:-20], line_of(RECORD).replace('"case"', '"c"')])
def test_a_line_that_is_no_record_is_told(line: str) -> None:
    with pytest.raises(MalformedRecordError):
        record_of(line)


def test_a_journal_goes_on_with_what_is_done_and_wanted(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "out")
    journal.begin()
    done, unwanted = run(), run(factor=2.0)
    failed = replace(run(factor=4.0), observations=None, status="timed out")
    for record in (done, unwanted, failed):
        journal.add(record)
    with journal.path.open("a", encoding="utf-8") as file:
        file.write(line_of(run(factor=8.0))[:50])  # the power went
    assert journal.go_on({done.id, failed.id, "tuned 8.0"}) == [done]
    assert journal.path.read_text(encoding="utf-8") == line_of(done) + "\n"


def test_runs_that_were_put_aside_are_found_when_they_are_wanted_again(tmp_path: Path) -> None:
    journal, both = Journal(tmp_path), {run().id, run(factor=2.0).id}
    for record in (run(), run(factor=2.0)):
        journal.add(record)
    assert journal.go_on({run().id}) == [run()]
    assert journal.go_on({run().id}) == [run()]
    assert journal.aside.read_text(encoding="utf-8") == line_of(run(factor=2.0)) + "\n"
    assert {record.id for record in journal.go_on(both)} == both
    assert not journal.aside.exists()


def test_a_bench_that_begins_anew_keeps_the_last_one(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    for record in (run(), run(factor=2.0)):
        journal.begin()
        journal.add(record)
    assert (tmp_path / "runs.jsonl.old").read_text(encoding="utf-8") == line_of(run()) + "\n"
    assert journal.go_on({"tuned 2.0"}) == [run(factor=2.0)]
