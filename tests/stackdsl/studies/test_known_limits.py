"""Limits against closed forms: both sides are within a millionth of them."""

import pytest

from stackdsl.studies.find_limit import End, LimitRequest, Want, find_in
from tests.stackdsl.studies.known_limits import KNOWN, Known

QUICK = (
    "stepped column by 12 mm, levels",
    "harmonic stack of 11, share of its overhangs",
    "plank that reaches out, in mm",
    "slab of friction 0.37, tilt in deg",
    "slab at 25 deg, friction",
    "tall carton, acceleration in g",
    "inverted V, friction",
    "beam on a block, load in g",
    "beam on a block, counterweight in g",
)

PROGRAMS = ("friction", "mass of back", "acceleration")  # of these scenes; a guess that is wrong would only cost time


@pytest.mark.parametrize(
    "known",
    [pytest.param(each, id=name, marks=[] if name in QUICK else pytest.mark.slow) for name, each in KNOWN.items()],
)
def test_the_limit_is_within_a_millionth_of_what_is_known(known: Known, request: pytest.FixtureRequest) -> None:
    found, truth = find_in(known.case(), "known", LimitRequest(known.want, known.name)), known.limit()
    assert found.end is End.LIMIT
    assert found.stands is not None
    assert found.beyond is not None
    assert found.by_program == (known.name in PROGRAMS or "finished" in request.node.callspec.id)
    if known.want is Want.MOST:
        assert (found.stands, found.beyond) == (truth, truth + 1)
    else:
        assert found.stands == pytest.approx(truth, rel=1e-6)
        assert found.beyond == pytest.approx(truth, rel=1e-6)
        assert (found.stands > found.beyond) == (known.want is Want.LEAST)
