"""The picture of a replay in a real browser: colours, forces with their scale, names, X-ray and camera."""

import re
from collections import Counter
from functools import cache
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from time import sleep
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image

from stackdsl.viewing.replay.page import replay_page
from stackdsl.viewing.run_view import RunView
from tests.chromium import complaints, opened, resize, settle, wait_for
from tests.stackdsl.viewing.test_replay_in_chromium import PULLS, asked, press, text_of
from tests.stackdsl.viewing.views import SLANT_TOWER, views_of

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

GROWING = """
    scenario: growing
    build:
      - column: {levels: 20}
        every: 0.1 s
    systems: [exact]
    expect: [{stands: all}]
"""
FAR_APART = """
    scenario: far-apart
    build:
      - column: {levels: 3}
        name: here
      - column: {levels: 3, origin: [20 m, 0 mm, 0 mm]}
        name: there
    systems: [exact]
    expect: [{stands: all}]
"""
SHELF = """
    scenario: shelf
    build:
      - {column: {levels: 2, step: 100 mm}, brick: {size: [400 mm, 300 mm, 150 mm], mass: 8 kg}}
    systems: [exact]
    expect: [{stands: all}]
"""
THROWN = """
    scenario: thrown
    build:
      - wall: {levels: 4, bricks: 3}
    impacts:
      - {at: 1 s, throw: {at: L4.2, from: {bearing: BEARING, distance: 200 mm}, speed: 4 m/s, name: shot}}
    systems: [exact]
    watch: 0.2 s
    expect: [{stands: {levels: 1}}]
"""
LEGEND = """[...document.querySelectorAll('.legend .entry')].map(
    e => [e.childNodes[1].textContent, +e.querySelector('.number').textContent])"""
# From the first to the last pixel with ink in the row of the bar, right of the middle of the picture.
BAR = """(() => {
    const over = document.querySelector('.over'), pen = over.getContext('2d'), ratio = over.width / over.clientWidth;
    const row = pen.getImageData(0, Math.round((over.clientHeight - 18) * ratio), over.width, 1).data;
    const half = over.width / 2;
    const ink = [...Array(over.width).keys()].filter(x => x > half && row[4 * x + 3] > 200);
    return (ink[ink.length - 1] - ink[0]) / ratio;
})()"""


@pytest.fixture(scope="module")
def falling() -> RunView:
    (found,) = views_of(PULLS)
    return found


@cache  # many tests look at the same run
def replay_of(text: str) -> str:
    return replay_page(views_of(text), "scene")


def show(browser: "Chrome", text: str, folder: Path) -> "Chrome":
    file = folder / "scene.html"
    file.write_text(replay_of(text), encoding="utf-8")
    opened(browser, file)
    return browser


def choose(page: "Chrome", title: str, value: str) -> None:
    page.execute_script(
        "const s = document.querySelector(`select[title='${arguments[0]}']`);"
        "s.value = arguments[1]; s.dispatchEvent(new Event('change'))",
        title,
        value,
    )


def picture_of(page: "Chrome") -> Image.Image:
    canvas = page.find_element("css selector", ".view canvas")
    return Image.open(BytesIO(canvas.screenshot_as_png)).convert("RGB")


def click(page: "Chrome", name: str) -> None:
    from selenium.webdriver import ActionChains  # noqa: PLC0415 -- only where there is a browser

    x, y = asked(page, f"replay.onScreen({name!r})")
    canvas = page.find_element("css selector", ".view canvas")
    across, down = (int(place - canvas.size[side] / 2) for place, side in ((x, "width"), (y, "height")))
    ActionChains(page).move_to_element_with_offset(canvas, across, down).click().perform()
    wait_for(lambda: text_of(page, ".inspector h2") == name)


def test_every_view_colour_and_overlay_can_be_chosen_without_a_complaint(undrawn: "Chrome", tmp_path: Path) -> None:
    page = show(undrawn, PULLS, tmp_path)
    page.execute_async_script(
        """
        const done = arguments[0], steps = [];
        for (const select of document.querySelectorAll('select'))
          for (const option of select.options)
            steps.push(() => { select.value = option.value; select.dispatchEvent(new Event('change')); });
        for (const button of document.querySelectorAll('button')) steps.push(() => button.click());
        for (const key of [' ', ',', '.', 'v', 'o', 'm', 'f', '0', '1', '2', '+', '-', '[', ']', 'Home', 'End'])
          steps.push(() => dispatchEvent(new KeyboardEvent('keydown', {key})));
        const frame = () => {
          if (!steps.length) return done();
          steps.shift()(); replay.seek(2); requestAnimationFrame(frame);
        };
        frame();
        """
    )
    assert complaints(page) == []


def test_a_brick_is_drawn_in_its_colour_where_it_is(browser: "Chrome", tmp_path: Path) -> None:
    page = show(browser, SLANT_TOWER, tmp_path)
    asked(page, "replay.seek(12.5)")
    asked(page, "replay.pickNamed('L7.1')")  # which colours its edges alone
    settle(page)
    x, y = asked(page, "replay.onScreen('L6.1')")
    picture = picture_of(page)
    colour = list(bytes.fromhex(asked(page, "replay.colourOf('L6.1')")))
    assert list(picture.getpixel((int(x), int(y)))) == pytest.approx(colour, abs=6)


def test_no_two_levels_that_touch_have_one_colour(undrawn: "Chrome", tmp_path: Path) -> None:
    page = show(undrawn, SLANT_TOWER, tmp_path)
    asked(page, "replay.seek(12.5)")
    choose(page, "colour by", "level")
    colours = [asked(page, f"replay.colourOf('L{level}.1')") for level in range(1, 8)]
    assert len(set(colours)) == 7
    light = [sum(int(code[at : at + 2], 16) for at in (0, 2, 4)) for code in colours]
    assert all(below < above for below, above in pairwise(light)), "the lowest level is the darkest"


def test_the_legend_counts_each_brick_that_is_there_once(undrawn: "Chrome", falling: RunView, tmp_path: Path) -> None:
    page = show(undrawn, PULLS, tmp_path)
    asked(page, "replay.seek(2)")
    bricks = [place for place in falling.timeline.placements if place.brick.id not in {"L3.2", "L4.2", "L5.2"}]
    for mode in ("state", "level", "room", "load", "stage"):
        choose(page, "colour by", mode)
        settle(page)
        counts = dict(asked(page, LEGEND))
        assert counts.pop("pulled out") == 3
        assert sum(counts.values()) == len(bricks) == 15
        if mode == "level":
            assert counts == Counter(f"level {place.level}" for place in bricks)


def test_colours_that_tell_nothing_say_why_and_keep_the_state(undrawn: "Chrome", tmp_path: Path) -> None:
    page = show(undrawn, PULLS, tmp_path)
    asked(page, "replay.seek(2)")
    state = asked(page, "replay.colourOf('L1.1')")
    choose(page, "colour by", "material")
    wait_for(lambda: "all bricks have one size and one density" in text_of(page, ".notice"))
    assert asked(page, "replay.colourOf('L1.1')") == state


CORBEL = """
    scenario: corbel
    brick: {size: [200 mm, 100 mm, 50 mm], mass: 0.2 kg}
    world: {walls: [{bearing: 180 deg, distance: 0 m}]}
    joints: [{bond: {tension: 0.1 MPa, cohesion: 2 MPa}}]
    build: [{bricks: [{at: [100 mm, 0 mm, 1 m], name: a}, {beside: a, name: b}, {beside: b, name: c}]}]
    systems: [exact]
    expect: [{stands: all}]
"""


def test_joints_have_the_colour_of_what_they_use_and_the_page_names_the_one_that_gives_way(
    undrawn: "Chrome", tmp_path: Path
) -> None:
    page = show(undrawn, CORBEL, tmp_path)
    wait_for(lambda: "Load factor 7.079; beyond it a, b, c tip over wall1" in text_of(page, "header"))
    choose(page, "colour by", "joints")
    wait_for(lambda: "joints at 7.079 times the weight" in text_of(page, ".legend"))
    legend = dict(asked(page, LEGEND))
    assert legend["a joint gives way first"] == 1  # that of a with the wall
    assert sum(legend.values()) == 3
    assert len({asked(page, f"replay.colourOf('{name}')") for name in "abc"}) >= 2
    asked(page, "replay.pickNamed('a')")
    wait_for(lambda: "gives way" in text_of(page, "aside"))
    before = picture_of(page).tobytes()
    press(page, "Joints")
    settle(page)
    assert picture_of(page).tobytes() != before


def test_a_dry_run_offers_no_joints(undrawn: "Chrome", tmp_path: Path) -> None:
    page = show(undrawn, PULLS, tmp_path)
    assert asked(page, "[...document.querySelectorAll('button')].find(b => b.textContent === 'Joints').hidden")
    assert asked(page, "[...document.querySelectorAll('option')].find(o => o.value === 'joints').hidden")


def test_forces_are_those_of_the_selected_brick_and_the_bar_is_as_long_as_the_force_it_names(
    undrawn: "Chrome", falling: RunView, tmp_path: Path
) -> None:
    page = show(undrawn, PULLS, tmp_path)
    press(page, "Parallel")
    choose(page, "view", "front")
    asked(page, "replay.seek(2)")
    click(page, "L2.1")
    press(page, "Forces")
    wait_for(lambda: asked(page, "replay.forces().length") > 0)
    proof = next(one for one in falling.proofs.standing if one.begin <= 2 < one.end)
    own = [
        np.linalg.norm(np.sum(contact.forces_W, axis=0))
        for contact in proof.contacts
        if "L2.1" in (contact.lower, contact.upper)
    ]
    drawn = asked(page, "replay.forces()")
    assert sorted(each["newtons"] for each in drawn) == pytest.approx(sorted(filter(None, own)), rel=1e-4)
    bar = asked(page, "replay.forceScale()")
    for each in drawn:
        length = np.hypot(*np.subtract(each["tip"], each["from"]))
        assert length == pytest.approx(bar["perNewton"] * each["newtons"], rel=1e-3)
    printed = re.fullmatch(r"([\d.]+) (m?)N", bar["text"])
    assert printed is not None
    newtons = float(printed[1]) / (1000 if printed[2] else 1)
    assert asked(page, BAR) == pytest.approx(bar["perNewton"] * newtons, abs=5)
    choose(page, "which forces", "largest")
    wait_for(lambda: len(asked(page, "replay.forces()")) == 10)
    assert "of" in asked(page, "replay.forceScale().title")
    assert complaints(page) == []


def test_arrows_of_the_motion_stay_on_their_bricks_while_these_move(undrawn: "Chrome", tmp_path: Path) -> None:
    page = show(undrawn, PULLS, tmp_path)
    press(page, "How it falls")
    before = dict[str, list[float]]()
    wait_for(lambda: before.update({name: at for name, at, _ in asked(page, "replay.motions()")}) or before)

    def moved() -> bool:
        now = asked(page, "replay.motions()")
        assert all(arrow == pytest.approx(brick, abs=1e-6) for _, arrow, brick in now)
        return any(np.linalg.norm(np.subtract(at, before[name])) > 2e-3 for name, at, _ in now)

    wait_for(moved)


def test_names_stand_on_faces_that_are_seen(undrawn: "Chrome", tmp_path: Path) -> None:
    page = show(undrawn, PULLS, tmp_path)
    asked(page, "replay.seek(2)")
    press(page, "Names")
    wait_for(lambda: len(asked(page, "replay.names()")) >= 12)  # of 15 bricks
    for name, seen in asked(page, "replay.names().map(([name, x, y]) => [name, replay.pickedAt(x, y)])"):
        assert seen == name


def test_x_ray_shows_and_selects_what_others_hide(undrawn: "Chrome", tmp_path: Path) -> None:
    page = show(undrawn, PULLS, tmp_path)
    asked(page, "replay.seek(2)")
    x, y = asked(page, "replay.onScreen('L1.2')")
    assert asked(page, f"replay.pickedAt({x}, {y})") not in ("", "L1.2")
    click(page, "L6.1")
    asked(page, "replay.pickNamed('L1.2')")
    press(page, "X-ray")
    wait_for(lambda: asked(page, f"replay.pickedAt({x}, {y})") == "L1.2")
    press(page, "X-ray")
    wait_for(lambda: asked(page, f"replay.pickedAt({x}, {y})") != "L1.2")


def test_the_camera_takes_in_what_has_grown_unless_somebody_turned_it(undrawn: "Chrome", tmp_path: Path) -> None:
    from selenium.webdriver import ActionChains  # noqa: PLC0415 -- only where there is a browser

    page = show(undrawn, GROWING, tmp_path)
    canvas = page.find_element("css selector", ".view canvas")
    for turned in (False, True):
        asked(page, "replay.seek(0.05)")
        press(page, "Fit")
        asked(page, "replay.seek(0.05)")
        if turned:
            ActionChains(page).move_to_element(canvas).click_and_hold().move_by_offset(3, 0).release().perform()
        asked(page, "replay.seek(3)")
        if turned:
            sleep(0.8)  # the camera has time to look and to move, 530 ms, and stays
        else:
            wait_for(lambda: asked(page, "replay.onScreen('L20.1')[1]") > 0)
        assert (asked(page, "replay.onScreen('L20.1')[1]") < 0) is turned


def test_of_structures_far_apart_one_is_seen_and_the_other_is_told(undrawn: "Chrome", tmp_path: Path) -> None:
    page = show(undrawn, FAR_APART, tmp_path)
    near = asked(page, "replay.perMetre()")
    assert near > 500, "a plank of 117.6 mm is wider than 50 px"
    press(page, "Fit")
    wait_for(lambda: asked(page, "replay.perMetre()") < near / 20)


@pytest.mark.parametrize("view", ["plan", "front"])
def test_a_lit_face_has_one_colour_and_no_pattern_of_its_own_shadow(
    browser: "Chrome", tmp_path: Path, view: str
) -> None:
    page = show(browser, SHELF, tmp_path)
    resize(page, 1200, 800, still=True)
    choose(page, "view", view)
    settle(page)
    x, y = map(int, asked(page, "replay.onScreen('L2.1')"))
    colours = picture_of(page).crop((x - 20, y - 20, x + 20, y + 20)).getcolors()
    assert colours is not None
    assert len(colours) == 1


@pytest.mark.parametrize("bearing", [143, *(pytest.param(each, marks=pytest.mark.slow) for each in (0, 90, -90))])
def test_a_throw_is_seen_from_the_side_and_told_with_the_brick_that_is_hit(
    undrawn: "Chrome", tmp_path: Path, bearing: int
) -> None:
    text = THROWN.replace("BEARING", f"{bearing} deg")
    page = show(undrawn, text, tmp_path)
    press(page, "Parallel")
    (view,) = views_of(text)
    hit = next(place for place in view.timeline.placements if place.hits)
    ends = []
    for time in (hit.time + 1e-4, hit.time + hit.flight / 2):
        asked(page, f"replay.seek({time})")
        ends.append((asked(page, "replay.onScreen('shot')"), asked(page, "replay.positionOf('shot')")))
    on_screen, way = (np.linalg.norm(np.subtract(*each)) for each in zip(*ends, strict=True))
    assert on_screen / way / asked(page, "replay.perMetre()") > 0.75
    assert re.search(
        r"shot is thrown.*shot would hit L3\.1[^;]* at [\d.]+ m/s; L.* simulated", text_of(page, ".events")
    )
