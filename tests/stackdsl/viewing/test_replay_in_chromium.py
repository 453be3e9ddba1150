"""A replay in a real browser, from a file, with the network off: it shows where bricks were, and names them."""

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlsplit

import numpy as np
import pytest

from stability.name_order import in_order, names_text
from stackdsl.diagnostics import ScenarioWarning, Span
from stackdsl.trace import EventKind
from stackdsl.viewing.drawing import solids_at
from stackdsl.viewing.replay.page import replay_page
from stackdsl.viewing.run_view import RunView
from tests.chromium import CUT, complaints, opened, resize, settle, wait_for
from tests.stackdsl.viewing.views import SLANT_TOWER, views_of

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

HOSTILE = """
    scenario: slant-tower
    description: "</script><script>document.title='ran'</script><!-- <b>bold</b>"
    build:
      - column: {levels: 1}
    systems: [exact]
    expect: [{stands: all}]
"""


@pytest.fixture(scope="module")
def tower() -> RunView:
    (found,) = views_of(SLANT_TOWER)
    return found


@pytest.fixture(scope="module")
def two_towers(tower: RunView, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("replays") / "tower.html"
    file.write_text(replay_page([tower, tower], "slant-tower"), encoding="utf-8")
    return file


@pytest.fixture
def page(undrawn: "Chrome", two_towers: Path) -> "Chrome":
    opened(undrawn, two_towers)
    return undrawn


def asked(page: "Chrome", script: str) -> Any:  # noqa: ANN401 -- whatever the page says
    return page.execute_script(f"return {script}")


def text_of(page: "Chrome", place: str) -> str:
    """The text of an element, with runs of white space as single spaces."""
    return " ".join(str(asked(page, f"document.querySelector({place!r}).textContent")).split())


def press(page: "Chrome", text: str) -> None:
    page.execute_script(
        "[...document.querySelectorAll('button')].find(b => b.textContent === arguments[0]).click()", text
    )


def test_a_replay_page_opens_from_a_file_without_requests_or_errors(page: "Chrome") -> None:
    assert asked(page, "performance.getEntriesByType('resource').length") == 0
    assert "Passed: collapses: expected at level 7" in text_of(page, "h1")
    icons = asked(page, "[...document.querySelectorAll('.tools .inside use')].map(use => use.getAttribute('href'))")
    assert len(set(icons)) == len(icons), "no two tools have one icon"
    assert asked(page, "[...document.querySelectorAll('use')].every(u => document.querySelector(u.href.baseVal))")
    assert complaints(page) == []


def test_scrubbing_to_the_collapse_moves_the_bricks_that_fell_to_where_they_were(
    page: "Chrome", tower: RunView
) -> None:
    assert tower.trace.collapse is not None
    for time in (tower.trace.collapse.time, tower.trace.cost.simulated_time):
        asked(page, f"replay.seek({time!r})")
        truth = tower.recording.at(time).positions
        for number, name in enumerate(tower.recording.names):
            drawn = asked(page, f"replay.positionOf({name!r})")
            assert drawn == pytest.approx(truth[number], abs=1e-4), name
    fell = {name for name, track in tower.trace.tracks.items() if track.left_at is not None}
    for name in fell:
        drawn = np.array(asked(page, f"replay.positionOf({name!r})"))
        assert drawn == pytest.approx(tower.trace.tracks[name].final.position_W, abs=1e-4)
        assert np.linalg.norm(drawn - tower.trace.tracks[name].placed.position_W) > 0.0039
    assert len(fell) > 5


def test_a_click_on_a_brick_names_it_and_what_it_rests_on(page: "Chrome", tower: RunView) -> None:
    from selenium.webdriver import ActionChains  # noqa: PLC0415 -- only where there is a browser

    asked(page, "replay.seek(12.5)")
    press(page, "Fit")
    asked(page, "replay.seek(12.5)")
    x, y = asked(page, "replay.onScreen('L7.1')")
    canvas = page.find_element("css selector", "main canvas")
    size = canvas.size
    ActionChains(page).move_to_element_with_offset(
        canvas, int(x - size["width"] / 2), int(y - size["height"] / 2)
    ).click().perform()
    wait_for(lambda: "L7.1" in text_of(page, ".inspector h2"))
    panel = text_of(page, ".inspector")
    assert panel.startswith("L7.1level 7")
    proof = next(one for one in tower.proofs.standing if one.begin <= 12.5 < one.end)
    shares = proof.bricks["L7.1"].rests_on
    assert sum(shares.values()) == pytest.approx(1.0)
    for name, share in shares.items():
        assert f"{name}{100 * share:.0f} %" in panel
    carried = [
        [sum(force[axis] for force in contact.forces_W) for axis in range(3)]
        for contact in proof.contacts
        if contact.upper == "L7.1"
    ]
    told = [float(each) for each in re.findall(r"%([\d.]+) mN", panel)]
    assert told == pytest.approx([1000.0 * np.linalg.norm(force) for force in carried], rel=5e-3)
    assert "Proofweight propagation" in panel
    assert "Written atscene.yaml:4:" in panel


def test_a_replay_plays_and_stops_at_its_end(page: "Chrome", tower: RunView) -> None:
    end = tower.trace.cost.simulated_time
    asked(page, f"replay.seek({end - 0.2!r})")
    press(page, "Play")
    wait_for(lambda: asked(page, "replay.time()") == pytest.approx(end))
    wait_for(lambda: asked(page, "[...document.querySelectorAll('button')].some(b => b.textContent === 'Play')"))


def test_a_click_on_the_collapse_goes_there(page: "Chrome", tower: RunView) -> None:
    from selenium.webdriver import ActionChains  # noqa: PLC0415 -- likewise

    assert tower.trace.collapse is not None
    x = asked(page, f"replay.onTimeline({tower.trace.collapse.time!r})")
    line = page.find_element("css selector", "footer .lanes")
    ActionChains(page).move_to_element_with_offset(line, int(x + 2 - line.size["width"] / 2), 0).click().perform()
    there = pytest.approx(tower.trace.collapse.time, abs=1e-6)
    wait_for(lambda: asked(page, "replay.time()") == there)


def test_names_and_texts_of_a_scenario_are_never_taken_for_a_program(undrawn: "Chrome", tmp_path: Path) -> None:
    file = tmp_path / "hostile.html"
    (view,) = views_of(HOSTILE, "<img src=x onerror=alert(3)>.yaml")
    view = replace(view, name="<script>alert(1)</script>")  # the language takes no such name of a brick
    file.write_text(replay_page([view], "<script>alert(2)</script>"), encoding="utf-8")
    opened(undrawn, file)
    wait_for(lambda: undrawn.title == "<script>alert(1)</script>: passed")
    assert "<title>&lt;script&gt;alert(2)" in file.read_text(encoding="utf-8")
    still = "new DOMParser().parseFromString(document.querySelector('noscript').textContent, 'text/html')"
    assert asked(undrawn, f"{still}.querySelector('.who b').textContent") == "<script>alert(1)</script>"
    assert asked(undrawn, f"{still}.querySelectorAll('script, img, [onerror]').length") == 0
    assert "</script><script>document.title='ran'</script><!-- <b>bold</b>" in text_of(undrawn, ".band")
    assert text_of(undrawn, ".who b") == "<script>alert(1)</script>"
    assert asked(undrawn, "document.querySelectorAll('img').length") == 0
    assert complaints(undrawn) == []


WITHOUT_WEBGL = """
const context = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
  return kind.startsWith('webgl') ? null : context.call(this, kind, ...more);
};
"""


@pytest.fixture
def scriptless(browser: "Chrome") -> Iterator["Chrome"]:
    browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    yield browser
    browser.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})


@pytest.mark.parametrize("width", [1280, 420])
def test_without_javascript_a_page_shows_the_verdict_and_a_drawing_of_the_end(
    scriptless: "Chrome", fall: Path, fallen: RunView, width: int
) -> None:
    screen = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    scriptless.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    scriptless.get(fall.as_uri())
    seen = scriptless.find_element("css selector", "body").text
    assert "Failed: stands: expected all, measured" in seen
    assert re.search(r"Why L\d.* tip over L3\.3", seen)
    assert "allow scripts for this page and reload it" in seen
    drawn = scriptless.find_elements("css selector", "figure > svg g > title")
    assert len(drawn) == len(fallen.recording.bricks) - 4  # all but those that were pulled out
    assert scriptless.execute_script(CUT) == []


def test_without_webgl_the_page_says_so_and_all_but_the_picture_works(browser: "Chrome", fall: Path) -> None:
    script = browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WITHOUT_WEBGL})
    try:
        opened(browser, fall)
    finally:
        browser.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)
    assert "Turn on graphics acceleration" in text_of(browser, ".view .notice")
    assert browser.find_element("css selector", ".view figure > svg").is_displayed()
    assert text_of(browser, "h1").startswith("Failed: stands")
    asked(browser, "replay.seek(2)")
    wait_for(lambda: "stands15" in text_of(browser, ".legend"))
    assert browser.execute_script(CUT) == []
    assert complaints(browser) == []


def test_the_policy_lets_no_other_program_run_and_nothing_be_fetched(page: "Chrome") -> None:
    page.execute_script(
        """
        const s = document.createElement('script'); s.textContent = 'window.ran = 1'; document.body.append(s);
        const i = new Image(); i.src = 'https://example.org/x.png'; document.body.append(i);
        fetch('https://example.org/').catch(() => undefined);
        """
    )
    told: list[str] = []

    def are_told() -> bool:
        told.extend(complaints(page))  # some come a while later
        return "\n".join(told).count("Content Security Policy") >= 3

    wait_for(are_told)
    assert asked(page, "window.ran") is None


def test_the_structure_fills_85_percent_of_an_orthographic_replay(page: "Chrome", tower: RunView) -> None:
    asked(page, "replay.seek(12.5)")
    press(page, "Parallel")
    page.execute_script(
        """
        const view = [...document.querySelectorAll('select')].find(s => [...s.options].some(o => o.value === 'front'));
        view.value = 'front'; view.dispatchEvent(new Event('change'));
        """
    )
    solids = solids_at(tower, 12.5)
    corners = np.concatenate([solid.corners for solid in solids.values()])
    wide, _, high = corners.max(axis=0) - corners.min(axis=0)
    low, top = (tower.recording.at(12.5).positions[tower.recording.names.index(name)] for name in ("L1.1", "L7.1"))
    canvas = page.find_element("css selector", "main canvas").size

    def filled() -> float:
        seen = [asked(page, f"replay.seek(12.5), replay.onScreen({name!r})") for name in ("L1.1", "L7.1")]
        scale = abs(seen[1][1] - seen[0][1]) / (top[2] - low[2])  # [px/m]
        return float(max(scale * wide / canvas["width"], scale * high / canvas["height"]))

    wait_for(lambda: filled() == pytest.approx(0.85, abs=0.01))


LEANING = """
    scenario: leaning
    build:
      - {column: {levels: 5, step: 12 mm}, every: 1 s}
      - {column: {levels: 3, step: 38 mm, origin: [0 mm, 200 mm, 0 mm]}, name: b, every: 1 s}
    systems: [exact]
    expect: [{stands: all}]
"""


def test_the_weakest_brick_and_the_one_with_least_room_are_told_apart(undrawn: "Chrome", tmp_path: Path) -> None:
    # Two planks whose centre is 57 mm out and 7.8 mm up tip over an edge that is 58.8 mm out. The fifth plank of the
    # other column is 48 mm out, and 10.8 mm inside of that edge.
    (run,) = views_of(LEANING)
    file = tmp_path / "leaning.html"
    file.write_text(replay_page([run], "leaning"), encoding="utf-8")
    opened(undrawn, file)
    wait_for(lambda: "Weakest above 0.23 g towards " in text_of(undrawn, ".band"))
    assert "above 0.23 g towards" in text_of(undrawn, ".lead")
    assert "L5.1, with its centre of mass 10.8 mm inside" in text_of(undrawn, ".band")
    for button, brick in (("Weakest", "b.L2.1"), ("Least room", "L5.1")):
        press(undrawn, button)
        wait_for(partial(asked, undrawn, f"document.querySelector('.inspector h2').textContent === {brick!r}"))
    assert complaints(undrawn) == []


STRUCK = """
    scenario: struck
    brick_types:
      block: {size: [200 mm, 100 mm, 60 mm], mass: 2.4 kg}
      box: {size: [150 mm, 150 mm, 150 mm], mass: 6 kg}
    brick: block
    friction: 0.6
    build:
      - wall: {levels: 8, bricks: 4}
    impacts:
      - after: built + 1 s
        throw: {brick: box, name: box, at: L6.2, from: {bearing: 90 deg, distance: 2 m}, speed: 9 m/s}
    systems: [exact]
    expect: [EXPECTED]
"""
LANES = """Object.fromEntries([...document.querySelectorAll('.lane')].map(lane => [
  lane.querySelector('.name').textContent,
  [...lane.querySelectorAll('.span, .mark')].map(part => part.title || part.textContent)]))"""


@pytest.fixture(scope="module")
def struck() -> RunView:
    (found,) = views_of(STRUCK.replace("EXPECTED", "collapses: any, falls: {count: '>= 4'}, drift: '> 1 mm'"))
    return found


def shown(page: "Chrome", run: RunView, tmp_path: Path) -> "Chrome":
    file = tmp_path / "run.html"
    file.write_text(replay_page([run], run.name), encoding="utf-8")
    opened(page, file)
    return page


def test_a_passed_run_opens_before_the_throw_and_a_failed_one_just_before_it_falls(
    undrawn: "Chrome", struck: RunView, tmp_path: Path
) -> None:
    page = shown(undrawn, struck, tmp_path)
    wait_for(lambda: "Passed" in text_of(page, ".band"))
    assert asked(page, "replay.time()") == pytest.approx(1.0, abs=2e-3)
    (failed,) = views_of(STRUCK.replace("EXPECTED", "falls: {count: 0}, leaves: {levels: 8}"))
    page = shown(page, failed, tmp_path)
    wait_for(lambda: "Failed" in text_of(page, ".band"))
    assert failed.trace.collapse is not None
    assert asked(page, "replay.time()") == pytest.approx(failed.trace.collapse.time, abs=2e-3)
    wait_for(lambda: asked(page, LANES)["Claims"])
    fell, fail = asked(page, LANES)["Claims"]
    assert "falls" in fell
    assert "fail" not in fell
    assert "2 claims fail" in fail  # at the end, where bricks are counted


def test_a_thrown_brick_is_seen_in_flight_and_no_brick_is_said_to_move_before_the_hit(
    undrawn: "Chrome", struck: RunView, tmp_path: Path
) -> None:
    page = shown(undrawn, struck, tmp_path)
    hit = next(event.time for event in struck.trace.events if event.kind is EventKind.HIT)
    woken = next(event for event in struck.trace.events if event.kind is EventKind.WOKEN)
    asked(page, f"replay.seek({0.5 * (woken.time + hit)})")
    wait_for(lambda: f"simulated, at rest{len(woken.bricks)}" in text_of(page, ".legend"))
    assert "moves" not in text_of(page, ".legend")
    assert asked(page, "replay.pickedAt(...replay.onScreen('box'))") == "box"  # and not the wall in front of it
    asked(page, f"replay.seek({hit + 0.1})")
    wait_for(lambda: "moves" in text_of(page, ".legend"))


def test_a_warning_about_the_files_of_a_run_is_in_its_band(undrawn: "Chrome", tower: RunView, tmp_path: Path) -> None:
    odd = ScenarioWarning(Span("load.csv", 3, 1, 2, ""), "'<b>' overhangs the deck", "move it")
    page = shown(undrawn, replace(tower, result=replace(tower.result, warnings=(odd,))), tmp_path)
    wait_for(lambda: "Warning load.csv:3:1: '<b>' overhangs the deck" in text_of(page, ".band"))


def test_what_fell_lies_and_only_the_others_stand_after_a_hit(
    undrawn: "Chrome", struck: RunView, tmp_path: Path
) -> None:
    page = shown(undrawn, struck, tmp_path)
    wait_for(lambda: asked(page, LANES)["Proof"])
    lanes, fallen = asked(page, LANES), sum(t.left_at is not None for t in struck.trace.tracks.values())
    contact = next(event.time for event in struck.trace.events if event.kind is EventKind.HIT)
    flight, wreck = lanes["Moves"][:2]
    assert flight.endswith("only box moves")
    assert float(wreck.split()[0]) == pytest.approx(contact, abs=0.02)  # no brick of the wall moves before
    assert re.search(r"\d+ bricks? move", wreck)
    assert lanes["Proof"][0].endswith("all bricks proven to stand")
    assert lanes["Proof"][-1].endswith(f"{36 - fallen} proven to stand, {fallen + 1} lie at rest")
    rests = [part for event in struck.trace.events for part in event.parts if part.kind is EventKind.FROZEN]
    asked(page, f"replay.seek({next(rest.time for rest in rests if 'box' in rest.bricks)})")
    wait_for(lambda: re.search(r"box lies? at rest", text_of(page, ".events")))  # alone, or with others
    assert "box stands" not in text_of(page, ".events")


def test_the_weakest_spot_is_that_of_the_wall_before_it_is_hit(
    undrawn: "Chrome", struck: RunView, tmp_path: Path
) -> None:
    page = shown(undrawn, struck, tmp_path)
    wait_for(lambda: "Weakest as built" in text_of(page, ".lead"))
    asked(page, f"replay.seek({struck.trace.cost.simulated_time})")
    press(page, "Weakest")
    wait_for(lambda: "It gives way first" in text_of(page, ".inspector"))
    assert asked(page, "replay.time()") < 1.3  # it goes to where the wall is whole
    asked(page, f"replay.seek({struck.trace.cost.simulated_time})")
    wait_for(lambda: "It gives way first" not in text_of(page, ".inspector"))


# The page around the picture: what it says, and that all of it can be read at every width, in light and in dark.


PULLS = """
    scenario: pulls
    build:
      - jenga: {levels: 6}
    impacts:
      - {at: 1 s, remove: {brick: L4.2}}
      - {at: 1.1 s, remove: {brick: L3.2}}
      - {at: 1.2 s, remove: {brick: L5.2}}
      - {at: 3 s, remove: {brick: L3.1}}
    systems: [exact]
    expect: [{stands: all}]
"""
SIZES = ((1280, 800), (1000, 800), (360, 900))

OVERLAPS = """
const found = [];
for (const lane of document.querySelectorAll('.lane')) {
  const boxes = [...lane.querySelectorAll('.mark')].map(m => m.getBoundingClientRect()).sort((a, b) => a.left - b.left);
  const edge = lane.getBoundingClientRect();
  boxes.forEach((box, at) => {
    if (at && box.left < boxes[at - 1].right) found.push([lane.textContent, at]);
    if (box.left < edge.left - 9 || box.right > edge.right + 9) found.push([lane.textContent, 'outside']);
  });
}
return found
"""


@pytest.fixture(scope="module")
def fallen() -> RunView:
    (found,) = views_of(PULLS)
    return found


@pytest.fixture(scope="module")
def fall(fallen: RunView, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("replays") / "pulls.html"
    file.write_text(replay_page([fallen], "pulls"), encoding="utf-8")
    return file


@pytest.fixture
def falling(undrawn: "Chrome", fall: Path) -> "Chrome":
    opened(undrawn, fall)
    return undrawn


def test_the_band_says_what_was_expected_what_was_measured_why_and_what_would_help(
    falling: "Chrome", fallen: RunView
) -> None:
    fell = sum(track.left_at is not None for track in fallen.trace.tracks.values())
    wait_for(lambda: falling.title == "pulls[exact]: failed")
    title, lead = text_of(falling, "h1"), text_of(falling, ".lead")
    assert title == f"Failed: stands: expected all, measured {fell} of 14 bricks fell"
    assert re.search(r"Why L\d.* tip over L3\.3.* After .*scene\.yaml:9:.*L3\.1 pulled out at 3 s", lead)
    assert re.search(r"Would help .* on L\d\.\d", lead)
    assert asked(falling, "document.querySelector('.band .image use').getAttribute('href')") == "#icon-failed"
    assert "scene.yaml:11:" in text_of(falling, ".who")
    assert "stackdsl explain scene.yaml" in text_of(falling, ".see code")


BOXES = """
    scenario: boxes
    build:
      - bricks: [NAMED]
      - wall: {levels: 4, bricks: 3}
    systems: [exact]
    expect: [{stands: all}]
""".replace("NAMED", ", ".join(f"{{name: box{number}, at: [0 mm, {number} m, 4 mm]}}" for number in range(1, 10)))


def test_events_name_bricks_as_the_terminal_does(undrawn: "Chrome", fallen: RunView, tmp_path: Path) -> None:
    (boxes,) = views_of(BOXES)
    for view in (fallen, boxes):
        (tmp_path / "replay.html").write_text(replay_page([view], "replay"), encoding="utf-8")
        opened(undrawn, tmp_path / "replay.html")
        assembly = set[str]()
        for event in (part for whole in view.trace.events for part in whole.parts):
            assembly |= set(event.bricks)
            asked(undrawn, f"replay.seek({event.time})")
            assert names_text(in_order(event.bricks), among=assembly) in text_of(undrawn, ".events")
            if event.kind is EventKind.REMOVED:
                assembly -= set(event.bricks)
    assert "L1.10 to L4.4 (14 bricks), box1 to box9 are set down" in text_of(undrawn, ".events")


def test_a_failed_run_opens_just_before_it_falls_and_one_that_stands_at_its_end(
    falling: "Chrome", tmp_path: Path
) -> None:
    assert asked(falling, "replay.time()") == pytest.approx(3.0, abs=2e-3)
    assert asked(falling, "document.querySelector('.events .now').textContent").startswith("1.200 s")
    (stands,) = views_of(LEANING)
    file = tmp_path / "stands.html"
    file.write_text(replay_page([stands], "stands"), encoding="utf-8")
    opened(falling, file)
    assert asked(falling, "replay.time()") == pytest.approx(stands.trace.cost.simulated_time)


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize(("width", "height"), SIZES)
def test_no_text_is_cut_off_and_no_marks_overlap(falling: "Chrome", width: int, height: int, dark: bool) -> None:
    resize(falling, width, height, dark)
    asked(falling, "document.querySelector('details').open = true")
    for time in (0.0, 1.15, 3.05):
        asked(falling, f"replay.seek({time})")
        press(falling, "Forces")
        settle(falling)
        assert f"{time:.3f} s" in text_of(falling, "output")
        assert falling.execute_script(CUT) == []
        assert falling.execute_script(OVERLAPS) == []
    assert complaints(falling) == []


def test_a_window_that_becomes_that_of_a_phone_shows_the_same_as_one_that_opens_as_such(falling: "Chrome") -> None:
    def spread() -> float:
        left, right = (asked(falling, f"replay.onScreen({name!r})[0]") for name in ("L6.1", "L6.3"))
        return float(right - left)

    resize(falling, 420, 900)
    opened(falling, Path(unquote(urlsplit(falling.current_url).path)))
    settle(falling)
    of_phone = spread()
    resize(falling, 1280, 500)
    opened(falling, Path(unquote(urlsplit(falling.current_url).path)))
    settle(falling)
    assert spread() != pytest.approx(of_phone, rel=0.2)
    resize(falling, 420, 900)
    wait_for(lambda: spread() == pytest.approx(of_phone, rel=0.05))


@pytest.mark.parametrize(("width", "height"), [*SIZES, (800, 900)])
def test_the_first_view_has_the_structure_in_the_middle_of_what_is_free(
    falling: "Chrome", fallen: RunView, width: int, height: int
) -> None:
    resize(falling, width, height, still=True)
    opened(falling, Path(unquote(urlsplit(falling.current_url).path)))
    scales = 24
    for _ in range(2):
        settle(falling)
        there = [name for name in fallen.recording.names if name not in {"L3.2", "L4.2", "L5.2"}]
        boxes = [asked(falling, f"replay.boxOf({name!r})") for name in there]
        left, top = (min(box[side] for box in boxes) for side in ("left", "top"))
        right, bottom = (max(box[side] for box in boxes) for side in ("right", "bottom"))
        wide, high = asked(falling, "(c => [c.clientWidth, c.clientHeight])(document.querySelector('.view canvas'))")
        assert (left + right) / 2 == pytest.approx(wide / 2, abs=0.01 * wide)
        assert (top + bottom) / 2 == pytest.approx((high - scales) / 2, abs=0.01 * high)
        assert min(left, top, wide - right, high - scales - bottom) > 0
        assert max((right - left) / wide, (bottom - top) / high) > 0.6
        press(falling, "Forces")
        scales = 58  # with that of forces


def test_marks_that_touch_are_joined_and_no_time_is_lost(falling: "Chrome") -> None:
    resize(falling, 420, 900)
    wait_for(lambda: "3 pulled out" in text_of(falling, ".lane"))
    titles = asked(falling, "[...document.querySelectorAll('.lane')][0].querySelectorAll('.mark')[1].title")
    assert [line.split(":")[0] for line in titles.splitlines()] == ["1.000 s", "1.100 s", "1.200 s"]
    assert asked(falling, "document.querySelectorAll('.lane')[0].querySelectorAll('.ticks i').length") == 5


ONE_BY_ONE = """
    scenario: one-by-one
    build:
      - {jenga: {levels: 6}, every: 1 s}
    impacts:
      - {after: built + 0.2 s, remove: {brick: L5.2}}
      - {after: built + 0.5 s, remove: {brick: L4.2}}
      - {after: built + 0.8 s, remove: {brick: L4.1}}
    systems: [exact]
    expect: [{stands: all}]
"""
LANE_MARKS = "[...document.querySelector('.lane').querySelectorAll('.mark')].map(m => m.textContent)"
TIMES_OF_AXIS = """[...document.querySelectorAll('.axis span')].map(
    s => [parseFloat(s.textContent), parseFloat(s.style.left)])"""


@pytest.fixture
def built(undrawn: "Chrome", tmp_path: Path) -> "Chrome":
    """A page on a tower that is set down for 17 s, brick by brick, and falls a second later."""
    (run,) = views_of(ONE_BY_ONE)
    file = tmp_path / "one-by-one.html"
    file.write_text(replay_page([run], "one-by-one"), encoding="utf-8")
    opened(undrawn, file)
    return undrawn


@pytest.mark.parametrize("width", [1280, 420])
def test_a_long_build_takes_a_small_part_of_the_time_line_and_is_one_mark(built: "Chrome", width: int) -> None:
    resize(built, width, 900)
    wide = asked(built, "document.querySelector('.lanes').clientWidth")
    assert 0 < asked(built, "replay.onTimeline(17)") < 0.4 * wide
    assert asked(built, "replay.onTimeline(17.8) - replay.onTimeline(17.2)") > 0.2 * wide
    marks = asked(built, LANE_MARKS)
    assert marks[0] == "build: 18 bricks"
    assert not any("set down" in text for text in marks)
    assert "drawn shorter" in asked(built, "document.querySelector('.break').title")
    times = asked(built, TIMES_OF_AXIS)
    for time, at in times:
        assert at == pytest.approx(asked(built, f"replay.onTimeline({time})"), abs=0.01)
    assert sum(time > 17 for time, _ in times) >= (1 if width < 1000 else 3)
    assert built.execute_script(OVERLAPS) == built.execute_script(CUT) == []


THROWN_LATE = """
    scenario: thrown-late
    build:
      - {column: {levels: 4}, every: 1 s}
    impacts:
      - {after: built + 0.2 s, throw: {at: L4.1, from: {bearing: 90 deg, distance: 50 mm}, speed: 1 m/s, name: shot}}
    systems: [exact]
    watch: 0.2 s
    expect: [{stands: {levels: 1}}]
"""


def test_a_throw_is_no_part_of_the_build(undrawn: "Chrome", tmp_path: Path) -> None:
    file = tmp_path / "thrown-late.html"
    file.write_text(replay_page(views_of(THROWN_LATE), "thrown-late"), encoding="utf-8")
    opened(undrawn, file)
    wait_for(lambda: asked(undrawn, LANE_MARKS)[:2] == ["build: 4 bricks", "shot, 3.2 s"])


def test_pointer_keys_and_playback_follow_the_scale_of_the_time_line(built: "Chrome") -> None:
    from selenium.webdriver import ActionChains, Keys  # noqa: PLC0415 -- only where there is a browser

    resize(built, 1280, 800)
    line = built.find_element("css selector", "footer .lanes")
    for time in (4.0, 17.2, 17.8):
        x = asked(built, f"replay.onTimeline({time})")
        ActionChains(built).move_to_element_with_offset(line, round(x - line.size["width"] / 2), 0).click().perform()
        wait_for(partial(asked, built, f"Math.abs(replay.time() - {time}) < 1e-6"))
    asked(built, "replay.seek(1), document.activeElement.blur()")
    ActionChains(built).key_down(Keys.SHIFT).send_keys(Keys.ARROW_RIGHT).key_up(Keys.SHIFT).perform()
    wait_for(lambda: asked(built, "replay.time()") > 1)
    assert asked(built, "replay.time()") == pytest.approx(1 + 17 / 4, rel=0.05), "the build plays for 4 s"
    asked(built, "replay.seek(17.3)")
    ActionChains(built).key_down(Keys.SHIFT).send_keys(Keys.ARROW_LEFT).key_up(Keys.SHIFT).perform()
    before = (1 - 0.3) * 17 / 4  # of the second that it goes back, 0.3 s are after the build
    wait_for(lambda: asked(built, "replay.time()") == pytest.approx(17 - before, abs=0.3))
    asked(built, "replay.seek(0)")
    press(built, "Play")
    frames, seconds, reached = built.execute_async_script(
        "const done = arguments[0], drawn = replay.drawn(), began = performance.now();"
        "setTimeout(() => done([replay.drawn() - drawn, (performance.now() - began) / 1000, replay.time()]), 1000)"
    )
    assert reached > 1.2 * min(seconds, 0.1 * frames), "a frame plays a tenth of a second at most"
    assert asked(built, "document.querySelector('.news').textContent") == "The build plays 4.3 times as fast."


def test_the_tools_are_one_row_at_1000_px_and_menus_on_a_phone(falling: "Chrome") -> None:
    tools = "[...document.querySelectorAll('.tools .button')].filter(b => b.offsetParent)"
    for width in (1280, 1000, 800, 700, 420):
        resize(falling, width, 800)
        boxes = asked(falling, f"{tools}.map(b => b.getBoundingClientRect())")
        assert len({round(box["top"]) for box in boxes}) == 1, width
        assert max(box["right"] for box in boxes) <= width
    assert len(boxes) == 4
    falling.execute_script("[...document.querySelectorAll('.opener')].find(b => b.textContent === 'Show').click()")
    assert "Forces" in asked(falling, f"{tools}.map(b => b.textContent)")


def test_forces_at_a_time_without_a_proof_say_so_and_lead_to_one(falling: "Chrome", fallen: RunView) -> None:
    assert text_of(falling, ".notice") == "" or asked(falling, "document.querySelector('.notice').hidden")
    press(falling, "Forces")
    asked(falling, "replay.seek(3.05)")
    wait_for(lambda: "Forces: No proof holds at this time" in text_of(falling, ".notice"))
    asked(falling, "document.querySelector('.notice .go').click()")
    wait_for(lambda: asked(falling, "document.querySelector('.notice').hidden"))
    there = asked(falling, "replay.time()")
    assert any(proof.begin <= there < proof.end for proof in fallen.proofs.standing)


def test_the_legend_counts_what_occurs_below_the_picture(falling: "Chrome", fallen: RunView) -> None:
    resize(falling, 420, 900)
    asked(falling, "replay.seek(2)")
    wait_for(lambda: "stands 15" in text_of(falling, ".legend").replace("stands15", "stands 15"))
    assert "pulled out3" in text_of(falling, ".legend")
    assert "moves" not in text_of(falling, ".legend")
    edge = "document.querySelector({!r}).getBoundingClientRect().{}"
    below, above = (asked(falling, edge.format(*each)) for each in ((".view", "bottom"), (".legend", "top")))
    assert above >= below


def test_nothing_plays_by_itself_and_the_keyboard_reaches_all_with_a_visible_focus(falling: "Chrome") -> None:
    from selenium.webdriver import ActionChains, Keys  # noqa: PLC0415 -- only where there is a browser

    resize(falling, 1280, 800, still=True)
    began = asked(falling, "replay.time()")
    reached = set()
    for _ in range(40):
        ActionChains(falling).send_keys(Keys.TAB).perform()
        at, style = asked(
            falling,
            "[document.activeElement.textContent || document.activeElement.title || document.activeElement.className,"
            " getComputedStyle(document.activeElement).outlineStyle]",
        )
        if at and "BODY" not in at:
            reached.add(at)
            assert style == "solid" or at == asked(falling, "document.body.textContent"), at
    assert {"Copy", "Details", "Fit", "Forces", "Play"} <= reached
    assert asked(falling, "replay.time()") == began
    ActionChains(falling).send_keys(",").perform()
    wait_for(lambda: asked(falling, "replay.time()") == pytest.approx(1.2))


def test_two_runs_beside_each_other_share_one_time_line_with_a_lane_each(page: "Chrome") -> None:
    page.execute_script(
        "const s = document.querySelector('select[title=beside]');s.value = '1'; s.dispatchEvent(new Event('change'))"
    )
    wait_for(lambda: "Both runs: passed" in text_of(page, "h1"))
    assert "First to differ no brick" in text_of(page, ".lead")
    names = asked(page, "[...document.querySelectorAll('.lane .name')].map(n => n.textContent)")
    assert names == ["Hands", "slant-tower[exact]", "slant-tower[exact]", "Claims"]


def test_a_page_of_several_runs_opens_with_one_that_failed_and_counts_these(
    undrawn: "Chrome", tower: RunView, fallen: RunView, tmp_path: Path
) -> None:
    (tmp_path / "runs.html").write_text(replay_page([tower, fallen], "runs"), encoding="utf-8")
    opened(undrawn, tmp_path / "runs.html")
    wait_for(lambda: text_of(undrawn, "h1").startswith("Failed: stands: expected all"))
    assert text_of(undrawn, ".runs label span") == "Run (1 of 2 failed)"
    options = asked(undrawn, "[...document.querySelector('.runs select').options].map(o => o.textContent)")
    assert options == ["slant-tower[exact]", "✗ pulls[exact]"]
    choose = (
        "const s = document.querySelector('select[title=beside]');s.value = '0'; s.dispatchEvent(new Event('change'))"
    )
    undrawn.execute_script(choose)
    heads = "[...document.querySelectorAll('.caption b')].map(b => b.textContent)"
    wait_for(lambda: asked(undrawn, heads) == ["pulls", "slant-tower"])
