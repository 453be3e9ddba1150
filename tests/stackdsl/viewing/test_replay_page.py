"""A replay page is one small file, made by the sources that lie beside it."""

import hashlib
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from stackdsl.simulation.recording import COLUMNS
from stackdsl.viewing.replay.page import harmless, payload_of, replay_page
from stackdsl.viewing.replay.verdict_band import verdict_json
from stackdsl.viewing.run_view import RunView
from tests.paths import ROOT
from tests.stackdsl.viewing.views import SLANT_TOWER, views_of

MEGABYTE = 1_000_000
FOUR_STACK = """
    scenario: four-stack
    build:
      - four_stack: {levels: 100}
    systems: [exact]
    expect: [{stands: all}]
"""


@pytest.fixture(scope="module")
def tower() -> RunView:
    (found,) = views_of(SLANT_TOWER)
    return found


def tumbling(view: RunView, looks: int) -> RunView:
    """The same bricks, each flying and turning a way of its own, shaken by a tenth of a millimetre at every look."""
    random = np.random.default_rng(7)
    count = len(view.recording.bricks)
    keys = np.zeros((count, looks, COLUMNS))
    times = np.arange(looks) / 60.0
    keys[..., 0] = np.arange(count)[:, None]
    keys[..., 1] = times
    way = random.normal(0.0, 0.5, (count, 1, 3)) * times[None, :, None] - [0.0, 0.0, 4.905] * times[None, :, None] ** 2
    keys[..., 2:5] = way + random.normal(0.0, 1e-4, (count, looks, 3))
    angle = random.normal(0.0, 5.0, (count, 1)) * times + random.normal(0.0, 2e-3, (count, looks))
    axis = random.normal(0.0, 1.0, (count, 1, 3))
    axis /= np.linalg.norm(axis, axis=2, keepdims=True)
    keys[..., 5:8], keys[..., 8] = axis * np.sin(angle / 2.0)[..., None], np.cos(angle / 2.0)
    return replace(view, recording=replace(view.recording, keys=keys.reshape(-1, COLUMNS)))


@pytest.mark.slow
def test_200_bricks_that_tumble_for_250_frames_take_a_megabyte_at_most() -> None:
    (view,) = views_of(FOUR_STACK)
    assert len(view.recording.bricks) == 200
    assert len(replay_page([tumbling(view, 250)], "heap").encode()) <= MEGABYTE


def test_the_program_in_the_package_is_the_one_that_its_sources_make() -> None:
    sources = ROOT / "replay"
    digest = hashlib.sha256()
    for file in (sources / "package-lock.json", *sorted((sources / "src").iterdir())):
        digest.update(file.read_bytes())
    bundle = (ROOT / "stackdsl" / "viewing" / "replay" / "replay.js").read_text(encoding="utf-8")
    assert bundle.endswith(f"// made from {digest.hexdigest()}\n"), "run `make replay`"


def test_the_lock_file_names_no_place_to_fetch_from() -> None:
    assert "resolved" not in (ROOT / "replay" / "package-lock.json").read_text(encoding="utf-8")


def test_the_page_asks_for_nothing_and_keeps_the_licence_of_what_is_in_it(tower: RunView) -> None:
    page = replay_page([tower], "tower")
    head = page.split("</style>")[0]
    assert "default-src 'none'" in head
    assert "Permission is hereby granted, free of charge" in head
    assert not re.search(r"""(src|href)\s*=\s*(?!"#icon-)""", page.split('id="program"')[0].split("</style>")[1])


def test_data_of_a_replay_page_cannot_end_its_script() -> None:
    text = "</script><!--<script>&"
    assert not set("<>&") & set(harmless(json.dumps(text)))
    assert json.loads(harmless(json.dumps(text))) == text


def test_the_band_shows_no_margin_where_only_the_shift_of_a_fall_is_known() -> None:
    told = "{build: [{column: {levels: %d}}], scenario: high, systems: [exact], expect: [stands: all]}"
    margins = []
    for levels in (20, 21):
        (view,) = views_of(told % levels)
        (claim,) = verdict_json(view, hurried=True)["claims"]
        margins.append(claim["margin"])
    assert margins[0].endswith(" mm")
    assert margins[1] == ""
    assert claim["measured"] == "21 bricks stand (largest shift 0 mm of 3.9 mm allowed)"


def test_a_page_of_joined_bricks_tells_the_load_factor_and_how_much_of_its_strength_each_joint_uses() -> None:
    # Blocks glued end to end out of a wall: the joint at the wall bears 9 times the moment of the outermost one.
    corbel = """
        scenario: corbel
        brick: {size: [200 mm, 100 mm, 50 mm], mass: 0.2 kg}
        world: {walls: [{bearing: 180 deg, distance: 0 m}]}
        joints: [{bond: {tension: 0.1 MPa, cohesion: 2 MPa}}]
        build: [{bricks: [{at: [100 mm, 0 mm, 1 m], name: a}, {beside: a, name: b}, {beside: b, name: c}]}]
        expect: [{stands: all}]
    """
    limit = payload_of(views_of(corbel)[0])["limit"]
    assert limit["factor"] == pytest.approx(7.079, abs=1e-3)
    assert limit["text"] == "a, b, c tip over wall1; the joint between wall1 and a gives way"
    assert limit["bricks"] == [0, 1, 2]
    joints = dict(zip(map(frozenset, zip(limit["lower"], limit["upper"], strict=True)), limit["used"], strict=True))
    assert [pair for pair, gives in zip(joints, limit["yields"], strict=True) if gives] == [{"wall1", 0}]
    assert joints[frozenset({"wall1", 0})] == 1.0
    assert 4.0 / 9.0 <= joints[frozenset({0, 1})] < 1.0
    assert 1.0 / 9.0 <= joints[frozenset({1, 2})] < joints[frozenset({0, 1})]
    assert payload_of(views_of(SLANT_TOWER)[0])["limit"] is None


def test_a_page_tells_the_share_of_its_strength_that_each_brick_uses() -> None:
    stack = """
        scenario: stack
        brick: {{size: [400 mm, 300 mm, 250 mm], mass: 12 kg, strength: {{stack: 30 kg}}}}
        build: [{{column: {{levels: {levels}}}}}]
        expect: [{{stands: all}}]
    """
    strength = payload_of(views_of(stack.format(levels=3))[0])["strength"]
    assert strength["bricks"] == [0, 1, 2]
    assert strength["used"] == pytest.approx([24 / 30, 12 / 30, 0.0], abs=1e-5)
    assert strength["crushes"] is None
    crushed = payload_of(views_of(stack.format(levels=4))[0])["strength"]
    assert crushed["crushes"] == 0
    assert crushed["used"][0] == pytest.approx(36 / 30, rel=1e-5)
    assert payload_of(views_of(SLANT_TOWER)[0])["strength"] is None
