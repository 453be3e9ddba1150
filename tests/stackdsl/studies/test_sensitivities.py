"""Sensitivities of margins, against slopes of closed forms."""

import re
from math import radians, sin

import pytest

from stackdsl.api.studies import sensitivities
from stackdsl.checking.cases import cases_of
from stackdsl.language.yaml.source import parse
from stackdsl.report.studies import HOW, sensitivity_lines, sensitivity_table
from stackdsl.studies.limit_search import SearchError
from stackdsl.studies.sensitivities import Effect, MarginKind, Sensitivities, SlopeSource
from tests.stackdsl.studies.known_limits import SEESAW, V

# The upper block, 60 mm high, turns about the end of the lower one at (100 mm - x) / 30 mm of g.
ON_END = """
friction: 3
build:
  - bricks:
      - {name: base, at: [0 mm, 0 mm, 10 mm], brick: {size: [200 mm, 100 mm, 20 mm], mass: 1 kg}}
      - {name: top, at: [X mm, 0 mm, 50 mm], brick: {size: [60 mm, 80 mm, 60 mm], mass: 100 g}}
"""
SLAB = "friction: 0.4\nbuild:\n  - bricks: [{name: slab, at: [0 mm, 0 mm, 3.9 mm]}]\n"


def of(text: str, margin: str = "acceleration", check: int = 2) -> Sensitivities:
    cases, mistakes = cases_of(parse(f"scenario: known\n{text}", "known.yaml"))
    assert not mistakes, mistakes
    return sensitivities(cases[0], margin, check)


def effect(found: Sensitivities, what: str) -> Effect:
    return next(each for each in found.effects if each.what == what)


def test_the_margin_decreases_towards_the_end_of_a_beam() -> None:
    found = of(ON_END.replace("X", "80"))
    assert found.margin == pytest.approx(20.0 / 30.0, rel=1e-6)
    for what, slope in (("x of top", -1.0 / 30.0), ("x of base", 1.0 / 30.0)):
        each = effect(found, what)
        assert [each.less, each.more] == pytest.approx([slope, slope], rel=1e-5)
        assert (each.source, each.has_kink, each.unit) == (SlopeSource.CHECKED, False, "mm")
    assert [each.what for each in found.effects if each.counts] == ["x of base", "x of top"]  # 1 % of 200 and 80 mm


@pytest.mark.slow
def test_two_cans_turn_about_the_rim_of_the_lower_one() -> None:
    """Radius 30 mm, heights 100 mm: the common centre is 5 mm off the axis below, and 100 mm above the ground."""
    text = """
brick: {cylinder: {diameter: 60 mm, height: 100 mm}, mass: 1 kg}
friction: 3
build:
  - bricks:
      - {name: low, at: [0 mm, 0 mm, 50 mm]}
      - {name: top, at: [10 mm, 0 mm, 150 mm]}
"""
    found = of(text)
    assert found.margin == pytest.approx(0.25, rel=2e-3)
    for what, slope in (("x of top", -0.005), ("x of low", 0.005)):
        each = effect(found, what)
        assert [each.less, each.more] == pytest.approx([slope, slope], rel=0.01)


def test_flush_on_what_it_lies_it_survives_less_either_way() -> None:
    text = ON_END.replace("X", "0").replace("[200 mm, 100 mm, 20 mm]", "[60 mm, 200 mm, 20 mm]")
    each = effect(of(text.replace("mass: 1 kg", "mass: 100 kg")), "x of top")
    #   The contact loses at one end what the block moves, and the block turns about that end: by 1 mm of 30 mm height.
    assert each.less == pytest.approx(1.0 / 30.0, rel=1e-4)
    assert each.more == pytest.approx(-1.0 / 30.0, rel=1e-4)
    assert (each.source, each.has_kink) == (SlopeSource.CHECKED, True)


def test_the_acceleration_margin_of_a_sliding_brick_is_its_friction() -> None:
    found = of(SLAB)
    assert found.margin == pytest.approx(0.4, rel=1e-6)
    each = effect(found, "friction of slab on ground")
    assert [each.less, each.more] == pytest.approx([1.0, 1.0], rel=1e-3)
    assert [other.what for other in found.effects if other.counts] == ["friction of slab on ground"]


def test_a_steeper_v_needs_less_friction() -> None:
    found = of(V, "friction", check=1)
    each = effect(found, "angle")
    slope = -0.5 / sin(radians(65.0)) ** 2 * radians(1.0)  # of (c - t / L) / 2, by a degree
    assert each.source is SlopeSource.CHECKED
    assert [each.less, each.more] == pytest.approx([slope, slope], rel=1e-5)


def test_a_counterweight_holds_by_its_moment() -> None:
    #   It turns about the end of the block, over which the beam is 5 mm high and what lies on it 15 mm.
    found = of("friction: 3" + SEESAW.replace("LOAD", "10"), check=0)
    moment = 30.0 * 20.0 + 3.0 * 50.0 - 10.0 * 50.0
    heights = 30.0 * 5.0 + 3.0 * 15.0 + 10.0 * 15.0
    assert found.margin == pytest.approx(moment / heights, rel=1e-6)
    more = (50.0 * heights - moment * 15.0) / heights**2  # by a gram of what lies behind
    less = (-50.0 * heights - moment * 15.0) / heights**2  # by a gram of the load
    assert effect(found, "mass of back").more == pytest.approx(more, rel=1e-5)
    assert effect(found, "mass of load").more == pytest.approx(less, rel=1e-5)


def test_a_plank_high_in_a_wall_moves_its_centre_of_mass_and_nothing_else() -> None:
    #   The wall tips at its least distance from the border over its height: the slope is the share of the plank's mass
    #   over that height, and finite differences agree.
    found = of("friction: 2\nbuild:\n  - wall: {levels: 4, bricks: 3, gap: 0 mm}\n", check=30)
    height, share = 4 * 7.8 / 2.0, 1.0 / 12.0
    checked = [effect(found, f"y of {name}") for name in ("L2.2", "L2.3", "L3.2")]
    for each in checked:
        assert [each.less, each.more] == pytest.approx([share / height, -share / height], rel=1e-3)
        assert each.source is SlopeSource.CHECKED


def test_sensitivities_need_a_standing_structure_with_a_margin() -> None:
    with pytest.raises(SearchError, match="UNSTABLE: top tips over base; only a stable structure has margins"):
        of(ON_END.replace("X", "110"))
    with pytest.raises(SearchError, match="the structure has no limit of friction"):
        of(SLAB, "friction")


@pytest.mark.parametrize(("last", "in_doubt"), [(SlopeSource.DUALS, True), (SlopeSource.CHECKED, False)])
def test_where_differences_contradict_forces_text_and_json_tell_that_the_rest_may_be_off(
    last: SlopeSource, in_doubt: bool
) -> None:
    # Also where the rest seems not to matter, as the forces say that are not unique.
    contradicted = Effect("x of a", "mm", 100.0, -0.1, 0.2, SlopeSource.DIFFERENCES)
    found = Sensitivities(
        "vee", MarginKind.ACCELERATION, 0.5, [contradicted, Effect("x of b", "mm", 100.0, 0.0, 0.0, last)]
    )
    text = "\n".join(sensitivity_lines(found, 15))
    assert ("at the limit are not unique: unchecked values may be wrong" in text) is in_doubt
    assert ("1 of 2 numbers have no effect (not checked)" in text) is in_doubt
    assert sensitivity_table([found]).details[0]["in_doubt"] is in_doubt


def test_a_number_without_a_margin_on_either_side_has_no_slopes_in_the_text() -> None:
    wedged = Effect("x of a", "mm", 100.0, None, None, SlopeSource.NONE)
    *_, row, _ = sensitivity_lines(Sensitivities("glued", MarginKind.LOAD_FACTOR, 3.0, [wedged]), 15)
    assert re.split(r" {2,}", row.strip()) == ["x of a", HOW[SlopeSource.NONE]]


def test_sensitivities_are_reported_as_text_csv_and_json() -> None:
    found = of(ON_END.replace("X", "80"), check=1)
    lines = list(sensitivity_lines(found, most=1))
    assert lines[0] == "known[exact] survives 0.666 g. It depends most on:"
    assert re.split(r" {2,}", lines[3].strip()) == ["x of base", "+0.0333 g/mm", "+0.0667 g", HOW[SlopeSource.CHECKED]]
    assert lines[5:] == [
        "  1 more number with less effect; --top 2 lists all",
        "  6 of 8 numbers have no effect (not checked)",
    ]
    table = sensitivity_table([found])
    assert table.csv().startswith("case,margin,what,unit,size,less,more,by_a_hundredth")
    told = table.details[0]
    assert (told["of"], told["effects"][0]["what"], told["effects"][1]["source"]) == (
        "acceleration",
        "x of base",
        "duals",
    )
