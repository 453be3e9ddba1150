"""The report of a check as pages: failures first, each case with picture and replay, and nothing taken for markup."""

import re
from dataclasses import replace
from html.parser import HTMLParser
from math import inf
from pathlib import Path
from urllib.parse import unquote

import pytest

from stackdsl.diagnostics import Span
from stackdsl.results import ClaimOutcome, Report, RunStatus, VariantResult
from stackdsl.viewing.check_report.charts import ChartAxis, charts
from stackdsl.viewing.check_report.page import ShownCase, file_name, index_page
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


def test_failures_come_first_in_the_report_page() -> None:
    page = index_page(Report((result("good"), result("bad", -1.0))), {}, {})
    assert page.index("bad[exact]") < page.index("good[exact]")
    assert '<tr data-passed="no">' in page
    assert "0 of 1 met" in page
    assert "a.yaml:7:5: stands: expected for 2 s, measured it did" in page


def test_each_case_links_to_its_replay_and_shows_its_picture() -> None:
    shown = {"good[exact]": ShownCase("replays/a%3Db.html#good%5Bexact%5D", "<svg></svg>")}
    elements = Elements(index_page(Report((result("good"), result("other"))), shown, {"other[exact]": "timed out"}))
    assert elements.links == ["replays/a%3Db.html#good%5Bexact%5D"]
    assert elements.names.count("svg") == 1
    assert elements.names.count("tr") == 3  # the head, and a row each


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
    (link,) = Elements((tmp_path / "report" / "index.html").read_text(encoding="utf-8")).links
    file, _, run = unquote(link).partition("#")
    assert run == "good[exact]"
    assert run in (tmp_path / "report" / file).read_text(encoding="utf-8")


def test_all_systems_that_play_the_same_share_a_page_with_their_golden_files(
    tmp_path: Path, stackdsl: Stackdsl
) -> None:
    (tmp_path / "good.yaml").write_text(GOOD.replace("expect:", "systems: [exact, thesis]\nexpect:"), encoding="utf-8")
    done = stackdsl("check", "good.yaml", "--html", "report", "--jobs", "1")
    assert "wrote report/index.html" in done.err, done.text
    links = Elements((tmp_path / "report" / "index.html").read_text(encoding="utf-8")).links
    pages = {unquote(link).partition("#")[0] for link in links}
    assert (len(links), len(pages)) == (2, 1)
    page = (tmp_path / "report" / pages.pop()).read_text(encoding="utf-8")
    names = re.findall(r'"name":"(good\[[^"]+)"', page)
    assert names == ["good[exact]", "good[exact], golden file", "good[thesis]", "good[thesis], golden file"]


def test_charts_stand_above_all_rows() -> None:
    page = index_page(Report(tuple(result("tower", 3.0, step=f"{step} mm") for step in range(4))), {}, {})
    assert page.index('<details class="studies" open>') < page.index("<table")


def test_a_map_holds_one_quantity_and_of_what_is_told_in_another_unit_only_whether_it_passed() -> None:
    runs = [result("tower", 3.0, step=f"{step} mm") for step in range(4)]
    bricks = replace(runs[3], outcomes=(replace(runs[3].outcomes[0], margin=-75.0, unit="bricks", passed=False),))
    line = charts([*runs[:3], bricks])
    assert line.count("<circle") == 3
    assert line.count('class="cross"') == 1
    assert "crosses: cases without a value in mm (1)" in line
    crossed = [result("tower", 5.0, a=f"{a} mm", b=f"{b} mm") for a in range(2) for b in range(2)]
    cells = charts([*crossed[:3], replace(crossed[3], outcomes=bricks.outcomes)])
    assert re.findall(r'class="(above|below)4"[^>]*>([^<]*)<', cells) == [("above", "5")] * 3 + [("below", "fails")]
    assert "margin -75 bricks" in cells  # to be read at the cell


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
    axis = ChartAxis(least, largest, 0.0, 100.0)
    assert list(axis.ticks()) == pytest.approx(ticks)
    assert (axis.place(least), axis.place(largest)) == (0.0, 100.0)


def test_names_of_variables_are_never_markup() -> None:
    runs = [result(HOSTILE, 1.0, **{HOSTILE: f"{step} mm", "b": f"{other}"}) for step in range(3) for other in range(2)]
    assert "<script" not in charts(runs) + charts([run for run in runs if ("b", "0") in run.parameters])
