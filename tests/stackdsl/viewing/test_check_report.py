"""The report of a check as pages: failures first, each case with picture and replay, and nothing taken for markup."""

import re
from dataclasses import replace
from html.parser import HTMLParser
from math import inf
from pathlib import Path
from urllib.parse import unquote

import pytest

from stackdsl.diagnostics import Span
from stackdsl.results import ClaimOutcome, FailureCause, Report, RunStatus, VariantResult
from stackdsl.trace import Measure
from stackdsl.viewing.check_report.charts import charts
from stackdsl.viewing.check_report.commit import commit_of
from stackdsl.viewing.check_report.page import Origin, ShownCase, file_name, index_page
from stackdsl.viewing.plots import Axis
from tests.command_line import GOOD, Stackdsl

SPAN = Span("a.yaml", 7, 5, 9)
HOSTILE = "<script>alert(1)</script>"


def result(name: str, margin: float = 1.0, **other: str) -> VariantResult:
    parameters = tuple(other.items())
    variant = ",".join([*(f"{key}={value}" for key, value in parameters), "exact"])
    outcome = ClaimOutcome("stands", "for 2 s", "it did", margin, "mm", margin >= 0.0, SPAN)
    done = VariantResult(name, variant, "exact", "a.yaml", RunStatus.DONE, "stands", outcomes=(outcome,))
    return replace(done, parameters=parameters)


class Elements(HTMLParser):
    """What elements a page has, and the links among them."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.names: list[str] = []
        self.links: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.append(tag)
        self.links += [value for key, value in attrs if key in ("href", "src") and value]


def links_of(page: Path) -> list[str]:
    """The links to other files."""
    return [link for link in Elements(page.read_text(encoding="utf-8")).links if not link.startswith("#")]


def test_failures_come_first_in_the_report_page() -> None:
    page = index_page(Report((result("good"), result("bad", -1.0))), {}, {})
    assert "1 of 2 cases failed" in page
    assert page.index('data-name="bad"') < page.index('data-name="good"')
    assert re.findall(r'<details class="row" data-status="(\w+)"', page) == ["failed", "passed"]
    assert "<dt>Expected</dt><dd>stands: for 2 s</dd><dt>Measured</dt><dd>it did (misses by 1 mm)</dd>" in page


def test_a_failure_shows_its_cause_and_the_line_of_its_claim() -> None:
    why = FailureCause("L2.1 tips over L1.1", before="L2.1 set down at 1 s", first="L2.1 had sunk 4.1 mm at 1.2 s")
    bad = replace(result("bad", -1.0), why=why)
    page = index_page(Report((bad,)), {}, {}, {"a.yaml": "\n".join(f"line {n}" for n in range(1, 10))})
    told = re.findall(r"<dt>(\w+)</dt><dd>([^<]*)</dd>", page)
    assert [label for label, _ in told] == ["Expected", "Measured", "Why", "After", "First"]
    assert dict(told)["Why"] == "L2.1 tips over L1.1"
    assert "<div class=meant><i>7</i>line 7</div>" in page


def test_a_report_of_some_cases_says_in_its_first_line_how_many_or_which() -> None:
    not_run = replace(result("late"), status=RunStatus.NOT_RUN)
    page = index_page(Report((result("good"), not_run), interrupted=True), {}, {})
    assert "Interrupted: 1 of 2 cases not run, none of the others failed</h1>" in page
    assert 'data-status="not run" aria-pressed="false"' in page
    failed = index_page(Report((result("bad", -1.0), not_run), interrupted=True), {}, {})
    assert "Interrupted: 1 of 2 cases not run, 1 failed</h1>" in failed
    shard = index_page(Report((result("good"), result("other"))), {}, {}, origin=Origin(shard="1/4"))
    assert "Shard 1/4: all 2 cases passed</h1>" in shard


def test_systems_that_agree_share_a_row_and_others_have_their_own() -> None:
    exact, other = result("tower"), replace(result("tower"), system="tuned", variant="tuned")
    assert index_page(Report((exact, other)), {}, {}).count('<details class="row"') == 1
    fell = replace(other, outcomes=(replace(other.outcomes[0], passed=False),))
    assert index_page(Report((exact, fell)), {}, {}).count('<details class="row"') == 2


def test_a_green_report_names_the_case_that_is_nearest_to_failing() -> None:
    far, near = (
        replace(r, outcomes=(replace(r.outcomes[0], margin=10.0 - v, numbers=(Measure(v, None, 10.0, "mm"),)),))
        for r, v in ((result("far"), 6.0), (result("near"), 9.9))
    )
    page = index_page(Report((far, near)), {}, {})
    assert "All 2 cases passed" in page
    assert page.index("<td>near[<wbr>exact]</td>") < page.index("<td>far[<wbr>exact]</td>")
    assert "1.0 % of its limit" in page


def test_the_commit_of_a_checkout_is_read_without_git(tmp_path: Path) -> None:
    git = tmp_path / ".git"
    (git / "refs" / "heads").mkdir(parents=True)
    (git / "HEAD").write_text("ref: refs/heads/main\n")
    assert commit_of(tmp_path) == ""
    (git / "refs" / "heads" / "main").write_text("0123456789" * 4 + "\n")
    assert commit_of(tmp_path / "scenarios") == "main 0123456789"
    (git / "HEAD").write_text("ref: refs/heads/../../../secret\n")
    (tmp_path.parent / "secret").write_text("f" * 40)
    assert commit_of(tmp_path) == ""


def test_each_case_links_to_its_replay_and_shows_its_picture() -> None:
    shown = {"good[exact]": ShownCase("replays/a%3Db.html#good%5Bexact%5D", '<svg class="small"></svg>')}
    page = index_page(Report((result("good"), result("other"))), shown, {"other[exact]": "timed out"})
    assert page.count('<svg class="small">') == 1
    assert "no replay: timed out" in page
    elements = Elements(page)
    assert [link for link in elements.links if not link.startswith("#")] == ["replays/a%3Db.html#good%5Bexact%5D"]
    assert elements.names.count("details") == 2  # a row each


def test_names_and_texts_are_never_markup() -> None:
    wrong = replace(result(HOSTILE), message=HOSTILE, file=HOSTILE, verdict=HOSTILE)
    elements = Elements(index_page(Report((wrong,)), {}, {wrong.name: HOSTILE}))
    assert elements.names.count("script") == 1  # its own, at the end


def test_a_case_has_a_file_of_its_own_that_every_system_takes() -> None:
    names = [file_name(case) for case in ("a[x=1,exact]", "a[x:1,exact]", "../a", "a" * 500, "é/ü")]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[A-Za-z0-9.=-]{1,100}\.html", name) for name in names)


def test_a_margin_over_one_variable_is_a_line_and_over_two_a_map() -> None:
    line = charts([result("tower", 3.0 - step, step=f"{step} mm") for step in range(6)])
    assert line.count("<circle") == 6
    assert "tower: margin of stands over step" in line
    assert ">step, mm</text>" in line  # what the axes are, with their units
    assert ">margin of stands, mm</text>" in line
    crossed = [result("tower", a - b, a=f"{a} mm", b=f"{b} mm") for a in range(3) for b in range(2)]
    cells = charts(crossed)
    assert cells.count("<td") == 6
    assert cells.count('class="below') == 1  # where a < b


def test_a_report_without_numbers_has_no_chart() -> None:
    assert not charts([result("a", kind="wood"), result("a", kind="stone"), result("b")])
    assert not charts([result("a", x="1 mm"), result("a", x="2 s"), result("a", x="3 mm")])  # of two kinds
    unmeasured = [replace(run, outcomes=(replace(run.outcomes[0], margin=inf),)) for run in [result("a", x="1")] * 4]
    assert not charts(unmeasured)


@pytest.mark.parametrize("extra", [(), ("--no-golden",)])
def test_check_writes_an_index_whose_links_lead_to_replays(
    tmp_path: Path, stackdsl: Stackdsl, extra: tuple[str, ...]
) -> None:
    (tmp_path / "good.yaml").write_text(GOOD, encoding="utf-8")
    done = stackdsl("check", "good.yaml", "--html", "report", "--jobs", "1", *extra)
    assert "wrote report/index.html" in done.err, done.text
    (link,) = links_of(tmp_path / "report" / "index.html")
    file, _, run = unquote(link).partition("#")
    assert run == "good[exact]"
    assert run in (tmp_path / "report" / file).read_text(encoding="utf-8")


def test_all_systems_that_play_the_same_share_a_page_with_their_golden_files(
    tmp_path: Path, stackdsl: Stackdsl
) -> None:
    (tmp_path / "good.yaml").write_text(GOOD.replace("expect:", "systems: [exact, thesis]\nexpect:"), encoding="utf-8")
    done = stackdsl("check", "good.yaml", "--html", "report", "--jobs", "1")
    assert "wrote report/index.html" in done.err, done.text
    links = links_of(tmp_path / "report" / "index.html")
    pages = {unquote(link).partition("#")[0] for link in links}
    assert (len(links), len(pages)) == (2, 1)
    page = (tmp_path / "report" / pages.pop()).read_text(encoding="utf-8")
    names = re.findall(r'"name":"(good\[[^"]+)"', page)
    assert names == ["good[exact]", "good[exact], golden file", "good[thesis]", "good[thesis], golden file"]


def test_charts_stand_above_all_rows() -> None:
    page = index_page(Report(tuple(result("tower", 3.0, step=f"{step} mm") for step in range(4))), {}, {})
    assert page.index('<section class="charts">') < page.index('<section id="cases">')


def test_a_map_holds_one_quantity_and_of_what_is_told_in_another_unit_only_whether_it_passed() -> None:
    runs = [result("tower", 3.0, step=f"{step} mm") for step in range(4)]
    bricks = replace(runs[3], outcomes=(replace(runs[3].outcomes[0], margin=-75.0, unit="bricks", passed=False),))
    line = charts([*runs[:3], bricks])
    assert line.count("<circle") == 3
    (mark,) = re.findall(r'class="mark" d="M[\d.]+ ([\d.]+)', line)
    assert float(mark) == 210.0  # at the bottom, as it failed
    assert "1 case without a value in mm" in line
    good = charts([*runs[:3], replace(bricks, outcomes=(replace(bricks.outcomes[0], passed=True),))])
    assert re.findall(r'class="mark" d="M[\d.]+ ([\d.]+)', good) == ["22.0"]  # at the top, as it passed
    crossed = [result("tower", 5.0, a=f"{a} mm", b=f"{b} mm") for a in range(2) for b in range(2)]
    cells = charts([*crossed[:3], replace(crossed[3], outcomes=bricks.outcomes)])
    assert re.findall(r'class="(above|below)4"[^>]*>([^<]*)<', cells) == [("above", "5")] * 3 + [("below", "fails")]
    assert 'b=1 mm,exact]: it did"' in cells  # to be read at the cell; the measured text counts the bricks


def test_a_claim_that_all_cases_tell_in_one_unit_is_drawn_rather_than_the_first() -> None:
    runs = [result("tower", 3.0, step=f"{step} mm") for step in range(3)]
    other = ClaimOutcome("creep", "< 1 mm", "0.4 mm", 0.6, "mm", passed=True, span=SPAN)
    units = zip(runs, "abc", strict=True)
    mixed = [replace(run, outcomes=(replace(run.outcomes[0], unit=unit), other)) for run, unit in units]
    assert "tower: margin of creep over step" in charts(mixed)


def test_lengths_in_several_units_lie_on_one_axis() -> None:
    line = charts([result("tower", 1.0, step=step) for step in ("20 mm", "1 cm", "0.03 m")])
    assert line.count("<circle") == 3
    assert re.findall(r'text-anchor="middle">([^<]+)</text>', line) == ["10", "15", "20", "25", "30", "step, mm"]


def test_other_variables_make_separate_lines_of_a_chart() -> None:
    runs = [result("tower", 1.0, step=f"{step} mm", kind=kind) for kind in ("wood", "stone") for step in range(3)]
    line = charts(runs)
    assert line.count("<polyline") == 2
    assert "exact, kind stone" in line


@pytest.mark.parametrize(
    ("least", "largest", "ticks"),
    [(0.0, 6.0, [0, 1, 2, 3, 4, 5, 6]), (-48.0, 6.0, [-40, -30, -20, -10, 0]), (0.1, 0.3, [0.1, 0.15, 0.2, 0.25, 0.3])],
)
def test_axes_have_round_numbers(least: float, largest: float, ticks: list[float]) -> None:
    axis = Axis(least, largest, 0.0, 100.0)
    assert list(axis.ticks()) == pytest.approx(ticks)
    assert (axis.place(least), axis.place(largest)) == (0.0, 100.0)


def test_names_of_variables_are_never_markup() -> None:
    runs = [result(HOSTILE, 1.0, **{HOSTILE: f"{step} mm", "b": f"{other}"}) for step in range(3) for other in range(2)]
    assert "<script" not in charts(runs) + charts([run for run in runs if ("b", "0") in run.parameters])
