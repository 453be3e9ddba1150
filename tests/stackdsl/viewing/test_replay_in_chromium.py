"""A replay in a real browser, from a file, with the network off: it shows where bricks were, and names them."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from stackdsl.viewing.drawing import solids_at
from stackdsl.viewing.replay.page import replay_page
from stackdsl.viewing.run_view import RunView
from tests.stackdsl.viewing.chromium import chromium, opened, wait_for
from tests.stackdsl.viewing.views import SLANT_TOWER, views_of

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

pytestmark = pytest.mark.xdist_group("chromium")

HOSTILE = """
    scenario: slant-tower
    description: "</script><script>document.title='ran'</script><!-- <b>bold</b>"
    build:
      - column: {levels: 1}
    systems: [exact]
    expect: [{stands: all}]
"""


@pytest.fixture(scope="module")
def browser() -> Iterator["Chrome"]:
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def tower() -> RunView:
    (found,) = views_of(SLANT_TOWER)
    return found


@pytest.fixture
def page(browser: "Chrome", tower: RunView, tmp_path: Path) -> "Chrome":
    file = tmp_path / "tower.html"
    file.write_text(replay_page([tower, tower], "slant-tower"), encoding="utf-8")
    opened(browser, file)
    return browser


def asked(page: "Chrome", script: str) -> Any:  # noqa: ANN401 -- whatever the page says
    return page.execute_script(f"return {script}")


def press(page: "Chrome", text: str) -> None:
    page.execute_script(
        "[...document.querySelectorAll('button')].find(b => b.textContent === arguments[0]).click()", text
    )


def complaints(page: "Chrome") -> list[str]:
    return [str(entry["message"]) for entry in page.get_log("browser")]  # type: ignore[no-untyped-call]


def test_a_replay_page_opens_from_a_file_without_requests_or_errors(page: "Chrome") -> None:
    assert asked(page, "performance.getEntriesByType('resource').length") == 0
    assert "slant-tower[exact]: collapses at level 7" in asked(page, "document.querySelector('h1').textContent")
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
    wait_for(lambda: asked(page, "!document.querySelector('.label').hidden"))
    label = asked(page, "document.querySelector('.label').textContent")
    assert "L7.1, level 7" in label
    proof = next(one for one in tower.proofs.standing if one.begin <= 12.5 < one.end)
    shares = proof.bricks["L7.1"].rests_on
    assert sum(shares.values()) == pytest.approx(1.0)
    assert f"rests on L6.1 {100 * shares['L6.1']:.0f} %, L6.2 {100 * shares['L6.2']:.0f} %" in label
    assert "proven by weight propagation" in label
    assert "scene.yaml:4:" in label


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
    line = page.find_element("css selector", "footer canvas")
    ActionChains(page).move_to_element_with_offset(line, int(x + 2 - line.size["width"] / 2), 0).click().perform()
    there = pytest.approx(tower.trace.collapse.time, abs=1e-6)
    wait_for(lambda: asked(page, "replay.time()") == there)


def test_every_view_colour_and_overlay_can_be_chosen_without_a_complaint(page: "Chrome") -> None:
    page.execute_script(
        """
        for (const select of document.querySelectorAll('select')) for (const option of select.options) {
          select.value = option.value; select.dispatchEvent(new Event('change')); replay.seek(12.5);
        }
        for (const b of document.querySelectorAll('button')) { b.click(); replay.seek(12.5); }
        for (const key of [' ', ',', '.', 'v', 'o', 'm', 'f', '0', '1', '2', '+', '-', '[', ']', 'Home', 'End'])
          dispatchEvent(new KeyboardEvent('keydown', {key}));
        """
    )
    assert complaints(page) == []


def test_names_and_texts_of_a_scenario_are_never_taken_for_a_program(browser: "Chrome", tmp_path: Path) -> None:
    file = tmp_path / "hostile.html"
    (view,) = views_of(HOSTILE, "<img src=x onerror=alert(3)>.yaml")
    view = replace(view, name="<script>alert(1)</script>")  # the language takes no such name of a brick
    file.write_text(replay_page([view], "<script>alert(2)</script>"), encoding="utf-8")
    opened(browser, file)
    assert browser.title == "<script>alert(2)</script>"
    assert asked(browser, "document.querySelector('header p').textContent").startswith(
        "</script><script>document.title"
    )
    assert asked(browser, "document.querySelector('h1').textContent").startswith("<script>alert(1)</script>: stands")
    assert asked(browser, "document.querySelectorAll('b').length") == 0
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
    press(page, "Orthographic")
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


def test_the_weakest_brick_and_the_one_with_least_room_are_told_apart(browser: "Chrome", tmp_path: Path) -> None:
    # Two planks whose centre is 57 mm out and 7.8 mm up tip over an edge that is 58.8 mm out. The fifth plank of the
    # other column is 48 mm out, and 10.8 mm inside of that edge.
    (run,) = views_of(LEANING)
    file = tmp_path / "leaning.html"
    file.write_text(replay_page([run], "leaning"), encoding="utf-8")
    opened(browser, file)
    notes = asked(browser, "document.querySelector('.notes').textContent")
    assert "weakest: b.L2.1; from 0.2308 g towards 0 deg on, b.L2.1, b.L3.1 tip over b.L1.1" in notes
    assert "least room: L5.1, whose centre is 10.8 mm inside" in notes
    for button, brick in (("Weakest", "b.L2.1, level 2"), ("Least room", "L5.1, level 5")):
        press(browser, button)
        shown = f"document.querySelector('.label').textContent.startsWith({brick!r})"
        wait_for(partial(asked, browser, shown))
    assert complaints(browser) == []
