"""Only the same sweep can resume a file of rows, and only one call at a time."""

import csv
import json
import os
import re
import resource
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import pytest

from stackdsl.studies import sweep_rows
from stackdsl.studies.sweep_plan import NothingToSweepError, SweepPlan, plan_of
from stackdsl.studies.sweep_rows import ParquetFolder, RowsError, TextRows
from tests.stackdsl.studies.sweeps import SHAKY, STEPS, cases, plan, swept

pytestmark = pytest.mark.usefixtures("at_once")


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """A file of 20 rows."""
    swept(plan(samples=20), tmp_path / "rows.jsonl")
    return tmp_path / "rows.jsonl"


@pytest.mark.parametrize(
    ("other", "why"),
    [
        (plan(samples=20, seed=2), r"'shaky[exact]' had the seed 1, and has 2 now"),
        (plan(SHAKY.replace("8 mm", "9 mm"), 20), r"'shaky[exact]' has changed since"),
        (plan(SHAKY.replace("shaky", "steady"), 20), r"it has no case 'steady[exact]', but shaky[exact]"),
        (plan(samples=10), "has more rows than the 10 of this sweep"),
    ],
)
def test_a_file_of_another_sweep_is_refused_and_left_as_it_is(out: Path, other: SweepPlan, why: str) -> None:
    was = out.read_bytes()
    with pytest.raises(RowsError, match=re.escape(why)):
        TextRows(out, other)
    assert out.read_bytes() == was


def test_a_file_of_another_version_or_program_is_refused(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    identity = out.with_name("rows.jsonl.sweep")
    text = identity.read_text()
    identity.write_text(text.replace('"stackdsl": "0', '"stackdsl": "9', 1))
    with pytest.raises(RowsError, match=r"written by stackdsl 9\S+, and this is 0"):
        TextRows(out, plan(samples=20))
    program = str(plan(samples=20).header["program"])
    identity.write_text(text.replace(program, "0" * 64, 1))
    with pytest.raises(RowsError, match="written by a different program"):
        TextRows(out, plan(samples=20))
    identity.unlink()
    with pytest.raises(RowsError, match=r"rows.jsonl.sweep, which a sweep writes beside it, is missing"):
        TextRows(out, plan(samples=20))


def test_a_link_in_place_of_the_identity_is_not_followed(out: Path, tmp_path: Path) -> None:
    identity = out.with_name("rows.jsonl.sweep")
    elsewhere = tmp_path.parent / f"{tmp_path.name}-elsewhere"
    identity.rename(elsewhere)
    identity.symlink_to(elsewhere)
    with pytest.raises(RowsError, match="a link leads out"):
        TextRows(out, plan(samples=20))


def test_rows_as_csv_are_those_of_json_lines_however_often_the_sweep_is_ended(tmp_path: Path) -> None:
    swept(plan(STEPS, 30), tmp_path / "rows.jsonl")
    swept(plan(STEPS, 30), tmp_path / "whole.csv")
    whole = (tmp_path / "whole.csv").read_bytes()
    for length in (0, 5, len(whole) // 3, len(whole) - 2, len(whole)):  # also within the names of the columns
        out = tmp_path / f"{length}.csv"
        swept(plan(STEPS, 3), out)
        out.write_bytes(whole[:length])
        swept(plan(STEPS, 30), out)
        assert out.read_bytes() == whole
    rows = [*csv.DictReader(whole.decode().splitlines())]
    expected = [json.loads(line) for line in (tmp_path / "rows.jsonl").read_text().splitlines()]
    told = [{name: "" if value is None else str(value) for name, value in row.items()} for row in expected]
    assert rows == told


def test_a_comment_or_what_is_expected_makes_no_other_sweep_of_it(out: Path) -> None:
    told = SHAKY.replace("build:", "description: the same\n# as before\nbuild:")
    expecting = told + 'expect: [stands: {{share: ">= 50 %"}}]\n'
    with TextRows(out, plan(expecting, 20)) as file:
        assert file.rows == 20


@pytest.mark.parametrize(
    "text", [b"a,b\n1,2\n", b"\x89PNG\r\n\x1a\n", b"{}\n", b"[1]\n", b"no end of line", b'"text"\n']
)
def test_a_sweep_never_overwrites_a_foreign_file(tmp_path: Path, text: bytes) -> None:
    (tmp_path / "mine.jsonl").write_bytes(text)
    with pytest.raises(RowsError, match="is not the file of a sweep"):
        TextRows(tmp_path / "mine.jsonl", plan())
    assert (tmp_path / "mine.jsonl").read_bytes() == text


def test_a_row_that_was_changed_is_told_by_its_line(out: Path) -> None:
    lines = out.read_text().splitlines(keepends=True)
    out.write_text("".join([*lines[:4], lines[5], lines[4], *lines[6:]]))
    with pytest.raises(RowsError, match=r"rows.jsonl:5: expected the row of sample 4 of shaky\[exact\]"):
        TextRows(out, plan(samples=20))
    out.write_text("".join([*lines[:4], lines[4].replace("verdict", "vardict"), *lines[5:]]))
    with pytest.raises(RowsError, match=r"rows.jsonl:5: expected the row of sample 4"):
        TextRows(out, plan(samples=20))


def test_two_sweeps_do_not_write_to_one_file(out: Path) -> None:
    with TextRows(out, plan(samples=30)), pytest.raises(RowsError, match=r"rows.jsonl is in use: another sweep"):
        TextRows(out, plan(samples=30))
    with TextRows(out, plan(samples=30)) as file:
        assert file.rows == 20


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_a_worker_that_outlives_a_sweep_that_was_killed_does_not_keep_its_file(out: Path) -> None:
    """A lock belongs to whoever has the file open, and a worker that is a copy of the sweep has what that has."""
    (begun, begins), (ends, tells) = os.pipe(), os.pipe()
    try:
        with TextRows(out, plan(samples=30)) as file:
            worker = os.fork()
            if worker == 0:
                os.close(tells)
                os.write(begins, b".")
                os.read(ends, 1)  # as long as the test is at it
                os._exit(0)
            os.read(begun, 1)
            with pytest.raises(RowsError, match="is in use"):
                TextRows(out, plan(samples=30))
            assert file.rows == 20
        with TextRows(out, plan(samples=30)) as file:
            assert file.rows == 20
    finally:
        for each in (begun, begins, ends, tells):
            os.close(each)
        assert os.waitpid(worker, 0) == (worker, 0)


def test_a_file_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    with pytest.raises(RowsError, match="cannot be written: Is a directory"):
        TextRows(tmp_path, plan())
    with pytest.raises(RowsError, match=r"must end in .jsonl or .csv for a file, or in .parquet for a folder"):
        swept(plan(), tmp_path / "rows.txt")
    os.mkfifo(tmp_path / "pipe.jsonl")
    with pytest.raises(RowsError, match="is not a regular file"):
        TextRows(tmp_path / "pipe.jsonl", plan())


def test_rows_that_the_disk_has_no_room_for_are_told_and_come_with_the_next_call(tmp_path: Path) -> None:
    whole, out = tmp_path / "whole.jsonl", tmp_path / "rows.jsonl"
    swept(plan(), whole)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (5000, hard))  # [bytes] of a file, in the middle of a row
    try:
        with pytest.raises(RowsError, match=r"rows\.jsonl cannot be extended: File too large; its rows are kept"):
            swept(plan(), out)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert out.stat().st_size == 5000
    (counted,) = swept(plan(), out)
    assert counted.rows == 300
    assert out.read_bytes() == whole.read_bytes()


def test_a_scenario_that_cannot_be_swept_is_refused() -> None:
    with pytest.raises(NothingToSweepError, match="no cases to sweep"):
        plan_of([])
    with pytest.raises(NothingToSweepError, match=r"'once\[exact\]' has no samples"):
        plan_of(cases("scenario: once\nbuild: [column: {{levels: 2}}]\n"), samples=5)
    with pytest.raises(NothingToSweepError, match=r"several cases are called 'shaky\[exact\]'"):
        plan_of([*cases(), *cases()])


def test_the_order_of_rows_can_be_begun_at_any_of_them() -> None:
    asked = plan(STEPS + "---\nscenario: once\nbuild: [column: {{levels: 2}}]\n", 4)
    whole = [*asked.order(0)]
    assert whole == [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (2, 0), (2, 1), (3, 0), (3, 1)]
    for row in range(asked.total + 1):
        assert [*asked.order(row)] == whole[row:]
    assert asked.at(asked.total) == (4, 0)


def test_parquet_has_the_same_rows_and_the_same_files_however_often_the_sweep_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    from stackdsl.studies import sweep as sweeps  # noqa: PLC0415 -- beside what it is for

    monkeypatch.setitem(sweeps.FORMS, ".parquet", lambda path, asked: ParquetFolder(path, asked, part=40))
    swept(plan(STEPS, 110), tmp_path / "rows.jsonl")
    swept(plan(STEPS, 110), tmp_path / "whole.parquet")
    for samples in (7, 20, 75, 110, 110):  # of two cases: within a file, at its end, beyond it
        (counted, _) = swept(plan(STEPS, samples), tmp_path / "parts.parquet")
        assert counted.rows == samples
    names = [f"part-{first:012}.parquet" for first in range(0, 220, 40)]
    for name in ["_tail.jsonl", *names]:
        assert (tmp_path / "parts.parquet" / name).read_bytes() == (tmp_path / "whole.parquet" / name).read_bytes()
    assert len([*(tmp_path / "parts.parquet").iterdir()]) == 7
    lines = (tmp_path / "rows.jsonl").read_text().splitlines()
    assert parquet.read_table(tmp_path / "whole.parquet").to_pylist() == [json.loads(line) for line in lines]


def test_parquet_that_was_killed_between_two_files_has_no_row_twice(tmp_path: Path) -> None:
    """A file was written, and its rows are still in the tail; or rows were put back, and the file is still there."""
    pytest.importorskip("pyarrow")
    asked, folder = plan(samples=50), tmp_path / "rows.parquet"
    swept(asked, tmp_path / "rows.jsonl")
    lines = (tmp_path / "rows.jsonl").read_bytes().splitlines(keepends=True)
    with ParquetFolder(folder, asked, part=20) as file:
        file.write(lines)
    (last,) = folder.glob("part-000000000040.parquet")
    kept = last.read_bytes()
    (folder / "_tail.jsonl").write_bytes(sweep_rows.header_line(asked, 40) + b"".join(lines[40:45]))
    with ParquetFolder(folder, asked, part=20) as file:
        assert file.rows == 45
        assert file.counts.rows == 45
        file.write(lines[45:])
    assert last.read_bytes() == kept
    with ParquetFolder(folder, asked, part=20) as file:
        assert file.counts.rows == file.rows == 50
        with pytest.raises(RowsError, match="is in use"):
            ParquetFolder(folder, asked)
    (folder / "part-000000000020.parquet").unlink()
    with pytest.raises(RowsError, match="lacks the rows from 20 on"):
        ParquetFolder(folder, asked, part=20)


@pytest.mark.parametrize("join", [os.symlink, os.link])
@pytest.mark.parametrize("name", ["_tail.jsonl", "_fresh", "part-000000000000.parquet"])
def test_parquet_neither_reads_nor_writes_what_a_link_leads_to(
    tmp_path: Path, name: str, join: Callable[[Path, Path], None]
) -> None:
    pytest.importorskip("pyarrow")
    asked, folder, elsewhere = plan(samples=50), tmp_path / "rows.parquet", tmp_path / "elsewhere"
    swept(asked, tmp_path / "rows.jsonl")
    lines = (tmp_path / "rows.jsonl").read_bytes().splitlines(keepends=True)
    with ParquetFolder(folder, asked, part=20) as file:
        file.write(lines[:30])
    if name == "_fresh":
        elsewhere.write_bytes(b"precious")
    else:
        (folder / name).rename(elsewhere)
    before = elsewhere.read_bytes()
    join(elsewhere, folder / name)
    # What is replaced as a whole is not written to, and a hard link to what is read is no other than a file.
    refused = name != "_fresh" and join is os.symlink
    with (
        pytest.raises(RowsError, match="a link leads out") if refused else nullcontext(),
        ParquetFolder(folder, asked, part=20) as file,
    ):
        file.write(lines[30:])
    assert elsewhere.read_bytes() == before
    (folder / name).unlink(missing_ok=True)
    if name == "_tail.jsonl":
        os.mkfifo(folder / name)
        with pytest.raises(RowsError, match="it is not a regular file"):
            ParquetFolder(folder, asked, part=20)
