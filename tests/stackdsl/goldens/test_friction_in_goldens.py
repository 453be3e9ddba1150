"""A golden file says what rubs otherwise than most, and nothing of it where nothing does."""

import json

from stability.contact_law import Friction, Rule
from stackdsl.goldens.comparison import compare
from stackdsl.goldens.file_format import canonical_text
from stackdsl.goldens.snapshot import friction_from, rubbing_of, scene_of
from stackdsl.timeline import FixedWorld
from tests.stackdsl.goldens.changes import STANDS, changed, put

LAW = Friction(0.5, {"sheet": 0.1}, {("sheet", "ground"): 0.6, ("L1.1", "sheet"): 0.2}, {"base": "sheet"}, Rule.MEAN)


def test_a_friction_law_is_read_back_from_a_golden_file() -> None:
    told = json.loads(json.dumps(rubbing_of(LAW)))
    again = friction_from(0.5, told)
    assert isinstance(again, Friction)
    assert {frozenset(pair): each for pair, each in again.between.items()} == {
        frozenset(pair): each for pair, each in LAW.between.items()
    }
    assert (again.own, again.kinds, again.rule) == (LAW.own, LAW.kinds, LAW.rule)


def test_a_single_friction_coefficient_is_locked_as_one_number() -> None:
    assert rubbing_of(0.5) is None
    assert friction_from(0.5, None) == 0.5
    assert "rubbing" not in canonical_text(STANDS)


def test_the_order_in_which_frictions_are_written_changes_no_golden() -> None:
    turned = Friction(0.5, {"sheet": 0.1}, {("sheet", "L1.1"): 0.2, ("ground", "sheet"): 0.6}, LAW.kinds, LAW.rule)
    assert list((rubbing_of(turned) or {}).items()) == list((rubbing_of(LAW) or {}).items())


def test_another_friction_of_a_pair_is_a_difference() -> None:
    rubbing = changed(put("world", "rubbing", value={"pair a/b": 0.25}))
    (difference,) = compare(rubbing, STANDS)
    assert (difference.subject, difference.quantity) == ("world", "friction, pair a/b")


def test_the_usual_friction_is_told_where_it_always_was() -> None:
    assert scene_of(FixedWorld(9.81, LAW, ())).friction == scene_of(FixedWorld(9.81, 0.5, ())).friction == 0.5
