"""Files that `stackdsl run` writes: arrays of poses, and a replay page."""

from pathlib import Path

import numpy as np
import pytest

from tests.command_line import GOOD, Stackdsl

TWO = GOOD.replace("expect:", "systems: [exact, thesis]\nexpect:")


@pytest.fixture
def good(tmp_path: Path) -> Path:
    (tmp_path / "good.yaml").write_text(GOOD, encoding="utf-8")
    (tmp_path / "two.yaml").write_text(TWO, encoding="utf-8")
    return tmp_path


def test_run_writes_arrays_and_a_page_where_it_is_asked_to(good: Path, stackdsl: Stackdsl) -> None:
    result = stackdsl("run", "good.yaml", "--record", "run.npz", "--html", "run.html")
    assert result.code == 0, result.text
    assert "wrote run.npz" in result.err
    assert "wrote run.html" in result.err
    with np.load(good / "run.npz", allow_pickle=False) as arrays:
        assert list(arrays["names"]) == ["L1.1", "L2.1", "L3.1"]
        assert arrays["time"] == pytest.approx([0.0, 1.0, 2.0])
    page = (good / "run.html").read_text(encoding="utf-8")
    assert "good[exact]" in page
    assert 'http-equiv="Content-Security-Policy"' in page


def test_one_page_holds_all_systems_of_a_file_and_arrays_hold_one_run(good: Path, stackdsl: Stackdsl) -> None:
    assert "choose one with --system or -k" in stackdsl("run", "two.yaml", "--record", "run.npz").err
    assert not (good / "run.npz").exists()
    assert stackdsl("run", "two.yaml", "--html", "run.html").code == 0
    page = (good / "run.html").read_text(encoding="utf-8")
    assert "two[" not in page
    assert "good[exact]" in page
    assert "good[thesis]" in page


@pytest.mark.parametrize(
    ("option", "name", "meant"), [("--record", "run.csv", "run.npz"), ("--html", "run.png", "run.html")]
)
def test_a_name_that_means_another_form_is_refused(
    good: Path, stackdsl: Stackdsl, option: str, name: str, meant: str
) -> None:
    result = stackdsl("run", "good.yaml", option, name)
    assert result.code == 4
    assert f"write {meant}" in result.err


def test_a_failed_run_names_its_page_or_the_command_that_writes_one(good: Path, stackdsl: Stackdsl) -> None:
    (good / "post.yaml").write_text(
        "scenario: post\nbrick: kapla\nbuild: [{bricks: [{name: post, at: [0 mm, 0 mm, 58.8 mm],"
        " rotate: [0 deg, 90 deg, 0 deg]}]}]\n"
        "impacts: [{after: built + 0.1 s, push: {brick: post, impulse: [0.01 N*s, 0 N*s, 0 N*s]}}]\n"
        "expect: [stands: all]\n"
    )
    (command,) = (line for line in stackdsl("run", "post.yaml").out.splitlines() if "see it" in line)
    assert command.endswith("stackdsl run post.yaml -k 'post[exact]' --html run.html")
    (seen,) = (
        line for line in stackdsl("run", "post.yaml", "--html", "my page.html").out.splitlines() if "see it" in line
    )
    assert seen.endswith("'my page.html', the page of this run")


def test_a_table_has_a_row_for_each_brick(good: Path, stackdsl: Stackdsl) -> None:
    told = stackdsl("run", "good.yaml", "--table").out
    header, *rows = told[told.index("name ") :].splitlines()[:4]
    assert header.split()[-2:] == ["shift_mm", "tilt_deg"]
    assert [row.split()[0] for row in rows] == ["L1.1", "L2.1", "L3.1"]
