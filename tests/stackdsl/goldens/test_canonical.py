"""The text of a snapshot: the same bytes for the same run, whatever the order, the names and the process."""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace
from math import nan
from typing import TypeVar

import pytest

from stability.model import Pose
from stackdsl.goldens.file_format import canonical_text, document
from stackdsl.goldens.snapshot import take
from stackdsl.trace import BrickState, Cost, Edge, Trace
from tests.stackdsl.goldens.towers import FALL, IDENTITY, STAMP, WORLD, taken, tower, track

T = TypeVar("T")


CANONICAL = """\
{
  "format": 1,
  "scenario": "tower",
  "variant": "thesis",
  "system": "thesis",
  "stamp": {"pybullet": "3.2.7", "python": "3.11", "stackdsl": "0.1.0"},
  "world": {"gravity": 9.81, "friction": 0.5, "planes": {"ground": {"at_mm": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0], "friction": 0.4}}},
  "verdict": "collapses",
  "collapse": {"level": 3, "time_s": 2.5, "gave_way": "L1.1"},
  "height_mm": 16.0,
  "levels_standing": 2,
  "events": [
    {"time_s": 0.0, "margin_mm": 12.0, "placed": {
      "L1.1": {"at_mm": [0.0, 0.0, 4.0], "turn_deg": [0.0, 0.0, 0.0], "size_mm": [120.0, 24.0, 8.0], "mass_g": 11.9, "rests_on": {"ground": 1.0}}
    }},
    {"time_s": 1.0, "placed": {
      "L2.1": {"at_mm": [0.0, 0.0, 12.0], "turn_deg": [0.0, 0.0, 0.0], "size_mm": [120.0, 24.0, 8.0], "mass_g": 11.9}
    }}
  ],
  "bricks": {
    "L1.1": {"level": 1, "state": "frozen", "at_mm": [0.0, 0.0, 4.0], "rests_on": {"ground": 1.0}},
    "L2.1": {"level": 2, "state": "frozen", "at_mm": [0.0, 0.0, 12.0], "rests_on": {"L1.1": 1.0}},
    "L3.1": {"level": 3, "state": "unplaced"}
  }
}
"""  # noqa: E501 -- a golden file has one line an event


def test_the_text_has_one_line_a_brick_and_an_event() -> None:
    assert canonical_text(taken(tower(track("L3.1", 3, BrickState.UNPLACED), collapse=FALL))) == CANONICAL


def test_the_text_is_the_json_of_the_document() -> None:
    snapshot = taken(tower())
    assert json.loads(canonical_text(snapshot)) == document(snapshot)


def test_an_empty_run_has_a_text() -> None:
    empty = Trace((), {}, (), None, Cost(0.0, 0.0, 0, 0), {})
    assert '"events": [],\n  "bricks": {}\n}\n' in canonical_text(taken(empty))


def test_the_text_is_rounded_and_has_no_negative_zero_and_no_infinity() -> None:
    place = Pose((-1e-9, 0.1 + 0.2, nan))
    snapshot = taken(tower(replace(track("L1.1", 1), placed=place)))
    assert '{"at_mm": [0.0, 300.0, "nan"], "turn_deg": [0.0, 0.0, 0.0]' in canonical_text(snapshot)


def test_the_text_is_ascii_whatever_the_names() -> None:
    snapshot = take(tower(), WORLD, replace(IDENTITY, scenario="tårn\ud800"), STAMP, modelled=True)
    assert r'"t\u00e5rn\ud800"' in canonical_text(snapshot)
    assert canonical_text(snapshot).isascii()


def test_the_order_of_bricks_edges_and_versions_does_not_reach_the_text() -> None:
    trace = tower()
    trace = replace(trace, edges=(*trace.edges, Edge("L3.1", "L1.1", 0.0)))
    turned = replace(trace, tracks=_reversed(trace.tracks), edges=trace.edges[::-1])
    assert canonical_text(take(turned, WORLD, IDENTITY, _reversed(STAMP), modelled=True)) == canonical_text(
        taken(trace)
    )


def _reversed(values: Mapping[str, T]) -> dict[str, T]:
    return dict(reversed(list(values.items())))


@pytest.mark.parametrize("seed", ["0", "1"])
def test_another_process_writes_the_same_bytes(seed: str) -> None:
    program = "from tests.stackdsl.goldens.test_canonical import *; print(canonical_text(taken(tower())), end='')"
    environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, check=True)
    assert done.stdout.decode("ascii") == canonical_text(taken(tower()))
