"""Numbers that have a limit, and errors for those that have none, in Python."""

import pytest

from stackdsl.api.studies import find
from stackdsl.checking.cases import Case, cases_of
from stackdsl.language.yaml.source import parse
from stackdsl.studies.find_limit import End, FoundLimit
from stackdsl.studies.limit_search import SearchError

# A column of N planks of 117.6 mm, each shifted by d, stands while N d is at most that.
COLUMN = """
scenario: leaning
let: {step: 12 mm, count: 12, wait: 1 s, kind: kapla}
brick: ${kind}
build:
  - column: {levels: "${count}", step: "${step}"}
    every: ${wait}
"""
CASES = """
scenario: pairs
cases:
  - {name: slow, step: 12 mm, levels: 8}
  - {name: fast, step: 10 mm, levels: 6}
build:
  - column: {levels: "${levels}", step: "${step}"}
"""
SPREAD = """
scenario: spread
samples: 100
uncertain: {step: 12 mm ± 2 mm}
build:
  - column: {levels: 8, step: "${step}"}
    every: 1 s
expect:
  - stands: {share: "> 10 %"}
"""
TWO = """
scenario: two
build:
  - column: {levels: 3, step: 5 mm}
  - column: {levels: 3, step: 6 mm, origin: [1 m, 0 m, 0 m]}
    name: b
"""
BALCONY = """
scenario: balcony
build:
  - column: {levels: 3}
  - bricks: [{name: arm, at: [70 mm, 0 mm, 27.3 mm]}]
impacts:
  - {push: {brick: arm, impulse: [0.01 N*s, 0 N*s, 0 N*s]}, at: 1 s}
"""


def cases(text: str) -> list[Case]:
    found, mistakes = cases_of(parse(text, "known.yaml"))
    assert not mistakes, mistakes
    return found


def told(finding: FoundLimit) -> float:
    assert finding.end is End.LIMIT
    assert finding.stands is not None
    return finding.stands


def test_of_the_values_of_a_case_one_is_other_and_the_rest_stays() -> None:
    slow, fast = (find(case, largest="step") for case in cases(CASES))
    assert told(slow) == pytest.approx(117.6 / 8.0, rel=1e-6)
    assert told(fast) == pytest.approx(117.6 / 6.0, rel=1e-6)
    assert slow.others == "other values of its case are unchanged: name = slow, levels = 8"


def test_of_what_is_uncertain_the_middle_is_in_place() -> None:
    found = find(cases(SPREAD)[0], largest="step")
    assert found.written == 12.0
    assert told(found) == pytest.approx(117.6 / 8.0, rel=1e-6)


def test_the_place_of_a_brick_is_a_number_and_what_is_pushed_later_is_not_asked() -> None:
    found = find(cases(BALCONY)[0], largest="x of arm")
    assert told(found) == pytest.approx(58.8, rel=1e-6)  # half its length
    assert (found.judged, found.bricks) == (4, 4)


def test_the_search_keeps_to_where_somebody_says() -> None:
    (case,) = cases(COLUMN)
    found = find(case, largest="step", from_="0.1 cm", to="5 mm")
    assert (found.end, found.stands, found.beyond) == (End.NONE, 5.0, None)
    with pytest.raises(SearchError, match="'5' has the wrong unit for 'step'; write, for example, 12 mm"):
        find(case, largest="step", to="5")
    with pytest.raises(SearchError, match="'5 kg' has the wrong unit for 'step'"):
        find(case, largest="step", to="5 kg")
    with pytest.raises(SearchError, match="the range from 5 mm to 1 mm is empty"):
        find(case, largest="step", from_="5 mm", to="1 mm")
    with pytest.raises(
        SearchError,
        match=r"the scenario is invalid with every number tried; with 200 mm, SD202: brick 'L2\.1' has no support",
    ):
        find(case, largest="step", from_="200 mm", to="300 mm")


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("stepp", "unknown number 'stepp'; did you mean 'step'?"),
        ("kind", "'kind' is the word 'kapla'; only a number has a limit"),
        (
            "wait",
            "'wait' is 1 s; statics does not depend on times or speeds, so it has no limit; vary it with `matrix`",
        ),
        ("mass of L99.1", "unknown brick 'L99.1'"),
    ],
)
def test_find_refuses_a_name_of_no_number_with_the_reason(name: str, why: str) -> None:
    with pytest.raises(SearchError) as refused:
        find(cases(COLUMN)[0], largest=name)
    assert why in str(refused.value)


def test_a_number_of_a_throw_is_varied_by_playing() -> None:
    throw = "impacts: [{throw: {at: L12.1, from: {bearing: 90 deg}, speed: 4 m/s}}]\n"
    told = "statics ends before a throw, push or drop; vary its numbers with `matrix`"
    with pytest.raises(SearchError, match=f"unknown number 'speed'; .*; {told}"):
        find(cases(COLUMN + throw)[0], largest="speed")
    with pytest.raises(SearchError, match=r"did you mean 'step'\?$"):
        find(cases(COLUMN + throw)[0], largest="stepp")


def test_what_cannot_be_asked_so_is_told_with_why() -> None:
    (case,) = cases(COLUMN)
    with pytest.raises(SearchError, match="not a whole number; use --largest instead of --most"):
        find(case, most="step")
    with pytest.raises(SearchError, match="a bearing applies only to the tilt or acceleration"):
        find(case, largest="step", bearing=1.0)
    with pytest.raises(SearchError, match="the tilt of the finished structure has no least value"):
        find(case, least="tilt")
    with pytest.raises(TypeError, match="one of largest, least and most"):
        find(case, largest="step", least="step")
    with pytest.raises(ValueError, match="within must be from"):
        find(case, largest="step", within=0.0)


def test_a_value_written_twice_is_refused_with_both_places() -> None:
    with pytest.raises(SearchError, match=r"'step' is written in 2 places: known.yaml:4:\d+, known.yaml:5:\d+"):
        find(cases(TWO)[0], largest="step")


def test_less_friction_than_none_is_asked_of_nothing() -> None:
    (case,) = cases(COLUMN.replace("count: 12", "count: 3"))
    found = find(case, least="friction")
    assert (found.end, found.stands, found.low) == (End.NONE, 0.0, 0.0)


def test_no_friction_holds_what_tips() -> None:
    found = find(cases(COLUMN)[0], least="friction")
    assert (found.end, found.stands) == (End.NOWHERE, None)
    assert "tip over L1.1" in found.why


def test_a_falling_structure_has_no_tilt_limit() -> None:
    found = find(cases(COLUMN)[0], largest="tilt")
    assert (found.end, found.stands) == (End.NOWHERE, None)


def test_a_wedged_brick_is_undecided_at_every_friction() -> None:
    walls = "walls: [{bearing: 0 deg, distance: 58.8 mm}, {bearing: 180 deg, distance: 58.8 mm}]"
    plank = "bricks: [{at: [0 mm, 0 mm, 103.9 mm]}]"
    found = find(cases(f"scenario: wedged\nworld: {{{walls}}}\nbuild:\n  - {plank}\n")[0], least="friction")
    assert (found.end, found.stands) == (End.OPEN, None)
    assert found.why.startswith("only self-stress can hold")
