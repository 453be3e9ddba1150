"""`stackdsl picture` draws a run to a file, in the form that its name says."""

import re
import shutil
from collections.abc import Iterator
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from stackdsl.cli.one_file import warn_of_missing_text
from stackdsl.viewing import svg
from stackdsl.viewing.svg import width_of
from tests.command_line import GOOD, Stackdsl

FALLS = GOOD.replace("levels: 3", "levels: 6, step: 21 mm").replace("stands: all", "collapses: any")
SOON = FALLS.replace("levels: 6, step: 21 mm", "levels: 3, step: 44 mm").replace("1 s", "0.1 s")  # few pictures
DENSITY = 557.0  # of a Kapla plank [kg/m3]
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(autouse=True)
def falls(tmp_path: Path) -> Path:
    (tmp_path / "falls.yaml").write_text(FALLS, encoding="utf-8")
    (tmp_path / "soon.yaml").write_text(SOON, encoding="utf-8")
    return tmp_path


def drawn(folder: Path, name: str) -> ET.Element:
    return ET.fromstring((folder / name).read_text(encoding="utf-8"))


def panels_of(root: ET.Element) -> list[ET.Element]:
    return root.findall(f"{SVG}svg")


def texts_of(element: ET.Element) -> list[str]:
    return [text.text or "" for text in element.iter(f"{SVG}text")]


def corners_of(path: str) -> np.ndarray:
    """The corners of a path of straight lines [px]."""
    return np.array([[float(number) for number in point.split()] for point in re.findall(r"[ML]([^MLZ]+)", path)])


def faces_of(panel: ET.Element) -> list[tuple[str, np.ndarray]]:
    """Bricks and their visible faces, in the order of painting."""
    groups = [group for group in panel.iter(f"{SVG}g") if group.find(f"{SVG}title") is not None]
    return [
        (group.findtext(f"{SVG}title") or "", corners_of(path.get("d", "")))
        for group in groups
        for path in group.iter(f"{SVG}path")
    ]


def width_of_brick(panel: ET.Element, name: str) -> float:
    points = np.concatenate([face for brick, face in faces_of(panel) if brick == name])
    return float(np.ptp(points[:, 0]))


def bar_of(panel: ET.Element) -> float:
    """The horizontal extent of the scale bar of a panel [px]."""
    bar = panel.findall(f"{SVG}path")[-1].get("d", "")
    return float(np.ptp([float(x) for x in re.findall(r"[ML]([-\d.]+) ", bar)]))


def test_each_view_is_a_panel_with_its_bricks_and_a_scale(falls: Path, stackdsl: Stackdsl) -> None:
    assert stackdsl("picture", "falls.yaml", "-o", "a.svg", "--at", "4.5").code == 0
    root = drawn(falls, "a.svg")
    texts = texts_of(root)
    assert texts[:2] == ["good[exact]", "4.5 s: all 5 bricks stand"]
    assert [text for text in texts if text.endswith(" view")] == ["three-quarter view", "front view", "plan view"]
    assert texts[-1] == "stands (5)"
    panels = panels_of(root)
    for panel in panels:
        assert {name for name, _ in faces_of(panel)} == {f"L{level}.1" for level in range(1, 6)}  # placed by then
    of_three, *of_others = [texts_of(panel) for panel in panels]
    assert (of_three, of_others) == (["20 mm along x"], [["20 mm"], ["20 mm"]])
    for panel in panels[1:]:
        assert bar_of(panel) / 20.0 == pytest.approx(width_of_brick(panel, "L1.1") / 117.6, rel=0.01)


def test_the_scale_of_the_three_quarter_view_is_that_of_lengths_along_x(falls: Path, stackdsl: Stackdsl) -> None:
    assert stackdsl("picture", "falls.yaml", "-o", "a.svg", "--at", "0.5", "--view", "three-quarter").code == 0
    (panel,) = panels_of(drawn(falls, "a.svg"))
    edges = [face[(k + 1) % len(face)] - face[k] for _, face in faces_of(panel) for k in range(len(face))]
    along_x = max(edges, key=lambda edge: float(np.linalg.norm(edge)))  # the longest side of a plank
    (label,) = texts_of(panel)
    length = float(label.removesuffix(" mm along x"))
    assert bar_of(panel) / length == pytest.approx(abs(along_x[0]) / 117.6, rel=0.01)


def test_arrows_of_forces_add_up_to_the_weight_by_the_scale_of_the_legend(falls: Path, stackdsl: Stackdsl) -> None:
    assert stackdsl("picture", "falls.yaml", "-o", "a.svg", "--at", "0.5", "--view", "front", "--forces").code == 0
    root = drawn(falls, "a.svg")
    paths = [corners_of(arrow.get("d", "")) for arrow in root.iter() if arrow.get("class") == "force"]
    *arrows, in_legend = (float(np.linalg.norm(tip - tail)) for tail, _, tip, *_ in paths)
    (label,) = [text for text in texts_of(root) if "forces of the proof" in text]
    newtons = float(label.removesuffix(" mN: forces of the proof")) / 1000.0
    weight = 0.1176 * 0.0234 * 0.0078 * DENSITY * 9.81
    assert sum(arrows) * newtons / in_legend == pytest.approx(weight, rel=0.01)


def inside(point: np.ndarray, outline: np.ndarray) -> bool:
    edges = np.roll(outline, -1, axis=0) - outline
    to_point = point - outline
    sides = edges[:, 0] * to_point[:, 1] - edges[:, 1] * to_point[:, 0]
    return bool((sides > 0.0).all() or (sides < 0.0).all())


def points_of(name: ET.Element) -> Iterator[np.ndarray]:
    """Points all over a name: its corners, and between them."""
    size = float(name.get("font-size", ""))
    middle = np.array((float(name.get("x", "")), float(name.get("y", "")) - 0.36 * size))
    angle = np.radians(float((re.findall(r"rotate\(([-\d.]+)", name.get("transform", "")) or ["0"])[0]))
    half = width_of(name.text or "", size) / 2.0
    for along in np.linspace(-half, half, 9):
        for across in (-0.36 * size, 0.0, 0.36 * size):
            yield (
                middle
                + along * np.array((np.cos(angle), np.sin(angle)))
                + across * np.array((-np.sin(angle), np.cos(angle)))
            )


@pytest.mark.parametrize("view", ["front", "plan", "three-quarter"])
def test_names_stand_on_their_bricks_where_no_other_covers_them(falls: Path, stackdsl: Stackdsl, view: str) -> None:
    tower = GOOD.replace("column: {levels: 3}", "four_stack: {levels: 14, step: 11.5 mm, spacing: 43 mm}")
    (falls / "tower.yaml").write_text(tower, encoding="utf-8")
    assert stackdsl("picture", "tower.yaml", "-o", "a.svg", "--names", "--view", view).code == 0
    root = drawn(falls, "a.svg")
    (panel,) = panels_of(root)
    faces = faces_of(panel)
    last = {name: place for place, (name, _) in enumerate(faces)}
    names = [text for text in panel.iter(f"{SVG}text") if text.get("class") == "name"]
    assert 3 < len(names) < len(last)
    for name in names:
        brick = name.text or ""
        points = list(points_of(name))
        assert any(each == brick and all(inside(point, face) for point in points) for each, face in faces)
        assert not any(inside(point, face) for point in points for _, face in faces[last[brick] + 1 :])
    assert f"no room for the names of {len(last) - len(names)} bricks" in texts_of(root)


def test_a_strip_shows_how_it_falls_at_one_scale_and_says_what_happens(falls: Path, stackdsl: Stackdsl) -> None:
    assert stackdsl("picture", "falls.yaml", "-o", "a.svg", "--strip", "4", "--view", "front").code == 0
    root = drawn(falls, "a.svg")
    panels, texts = panels_of(root), texts_of(root)
    assert len({ET.tostring(panel) for panel in panels}) == len(panels) == 4
    assert len({round(width_of_brick(panel, "L1.1"), 1) for panel in panels}) == 1
    assert len({(panel.get("width"), panel.get("height")) for panel in panels}) == 1
    times = [text for text in texts if re.fullmatch(r"\d+\.\d\d s", text)]
    assert times == sorted(times)
    assert len(times) == 4
    told = " ".join(texts)
    assert "all 5 bricks stand" in told
    assert "L2.1 to L6.1 (5 bricks) tip over L1.1" in told
    assert re.search(r"L\d\.1 has (moved|tilted) [\d.]+ (mm|deg)", told)
    assert "end: 1 brick stands, 5 have fallen" in told
    assert "thrown or dropped" not in told  # the legend lists only what occurs


def test_a_brick_that_is_pulled_out_leaves_an_outline_while_the_others_stand(falls: Path, stackdsl: Stackdsl) -> None:
    pulled = GOOD.replace("expect:", "impacts:\n  - {after: built + 1 s, remove: {brick: L3.1}}\nexpect:")
    (falls / "pulled.yaml").write_text(pulled, encoding="utf-8")
    for time, outlines, legend in (("2.5", set(), ["stands (3)"]), ("3.5", {"L3.1"}, ["stands (2)", "pulled out (1)"])):
        assert stackdsl("picture", "pulled.yaml", "-o", "a.svg", "--at", time, "--view", "front").code == 0
        root = drawn(falls, "a.svg")
        groups = [group for group in root.iter(f"{SVG}g") if group.find(f"{SVG}title") is not None]
        hollow = {group.findtext(f"{SVG}title") for group in groups if group.findall(f"{SVG}path[@fill='none']")}
        assert hollow == outlines
        assert texts_of(root)[-len(legend) :] == legend


def test_a_long_strip_keeps_its_panels_large_enough_to_be_seen(falls: Path, stackdsl: Stackdsl) -> None:
    assert stackdsl("picture", "falls.yaml", "-o", "a.svg", "--strip", "40", "--view", "front").code == 0
    panels = panels_of(drawn(falls, "a.svg"))
    assert len(panels) == 40
    assert all(width_of_brick(panel, "L1.1") > 40.0 for panel in panels)


@pytest.mark.parametrize("tilt", ["0.001 deg", "20 deg"])
@pytest.mark.parametrize("view", ["front", "side", "plan", "three-quarter"])
def test_a_tilted_ground_has_a_grid_only_where_it_ends(falls: Path, stackdsl: Stackdsl, tilt: str, view: str) -> None:
    tilted = GOOD.replace("build:", f"world: {{tilt: {tilt}}}\nbuild:")
    (falls / "tilted.yaml").write_text(tilted, encoding="utf-8")
    assert stackdsl("picture", "tilted.yaml", "-o", "a.svg", "--view", view, "--at", "0.5").code == 0
    assert (falls / "a.svg").stat().st_size < 20_000


@pytest.mark.parametrize(
    ("name", "begins", "library"),
    [("a.png", b"\x89PNG", "resvg_py"), ("a.gif", b"GIF89a", "PIL"), ("a.webp", b"RIFF", "PIL")],
)
def test_the_name_of_the_file_says_in_which_form_it_is(
    falls: Path, stackdsl: Stackdsl, name: str, begins: bytes, library: str
) -> None:
    pytest.importorskip("resvg_py")
    pytest.importorskip(library)
    assert stackdsl("picture", "soon.yaml", "-o", name).code == 0
    assert (falls / name).read_bytes().startswith(begins)


def test_png_files_show_the_text_of_their_svg(falls: Path, stackdsl: Stackdsl) -> None:
    pytest.importorskip("resvg_py")
    image = pytest.importorskip("PIL.Image")
    if not list(Path("/usr/share/fonts").rglob("DejaVuSans.ttf")):
        pytest.skip("needs a font")
    assert stackdsl("picture", "soon.yaml", "-o", "a.png").code == 0
    assert stackdsl("picture", "soon.yaml", "-o", "a.svg").code == 0
    title = re.search(r'<text x="([\d.]+)" y="([\d.]+)".*font-size="([\d.]+)"', (falls / "a.svg").read_text("utf-8"))
    assert title is not None
    x, y, size = (2 * float(part) for part in title.groups())  # a PNG has two pixels per unit of SVG
    letters = image.open(falls / "a.png").convert("L").crop((int(x), int(y - size), int(x + 4 * size), int(y)))
    darkest, lightest = letters.getextrema()
    assert lightest - darkest > 100


def test_a_png_without_its_fonts_has_no_text(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("resvg_py")
    monkeypatch.setattr(svg, "FONT_OF_PNG", "'No Such Font'")
    svg.png_has_text.cache_clear()
    try:
        with redirect_stderr(StringIO()) as told:
            warn_of_missing_text(tmp_path / "a.png")
            warn_of_missing_text(tmp_path / "a.svg")
    finally:
        svg.png_has_text.cache_clear()
    assert told.getvalue().count("has no text") == 1


def test_of_several_cases_it_says_which_one_it_draws_and_how_to_choose_another(falls: Path, stackdsl: Stackdsl) -> None:
    (falls / "two.yaml").write_text(GOOD.replace("expect:", "systems: [exact, thesis]\nexpect:"), encoding="utf-8")
    result = stackdsl("picture", "two.yaml", "-o", "a.svg", "--at", "0.5")
    assert (
        "drawing good[exact], the first of 2; choose another with --system or -k, such as -k 'good[thesis]'"
        in result.err
    )
    again = stackdsl("picture", "two.yaml", "-o", "b.svg", "--at", "0.5", "-k", "good[thesis]")
    assert "drawing" not in again.err
    assert texts_of(drawn(falls, "b.svg"))[0] == "good[thesis]"


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("a.svg", "--at", "1", "--strip", "3"), "remove one of the two"),
        (("a.gif", "--at", "1"), "remove --at and --strip"),
        (("a.gif", "--view", "front", "--view", "plan"), "give only one --view"),
        (("a.svg", "--strip", "3", "--view", "front", "--view", "plan"), "give only one --view"),
        (("a.svg", "--at", "1e6"), "good[exact] ends at"),
    ],
)
def test_picture_refuses_options_that_it_would_ignore(
    falls: Path, stackdsl: Stackdsl, options: tuple[str, ...], told: str
) -> None:
    result = stackdsl("picture", "falls.yaml", "-o", *options)
    assert result.code == 4
    assert told in result.err
    assert not (falls / options[0]).exists()


def test_picture_says_if_there_are_no_forces_at_a_time(stackdsl: Stackdsl) -> None:
    assert "no forces are drawn at" in stackdsl("picture", "falls.yaml", "-o", "a.svg", "--forces", "--at", "5.2").err
    assert "no forces are drawn" not in stackdsl("picture", "falls.yaml", "-o", "a.svg", "--forces", "--at", "4.5").err


def test_a_name_that_means_no_picture_is_refused(stackdsl: Stackdsl) -> None:
    result = stackdsl("picture", "falls.yaml", "-o", "a.txt")
    assert result.code == 4
    assert "a.txt: the file name must end in .svg, .png, .gif, .webp, .mp4" in result.err


def test_a_film_is_made_where_there_is_ffmpeg(falls: Path, stackdsl: Stackdsl) -> None:
    pytest.importorskip("resvg_py")
    if shutil.which("ffmpeg") is None:
        pytest.skip("needs ffmpeg")
    assert stackdsl("picture", "soon.yaml", "-o", "a.mp4", "--view", "front").code == 0
    film = (falls / "a.mp4").read_bytes()
    assert film[4:8] == b"ftyp"
    assert film.index(b"moov") < film.index(b"mdat")  # it plays before it is there as a whole


def test_without_ffmpeg_a_film_is_refused_with_what_to_do(falls: Path, stackdsl: Stackdsl) -> None:
    result = stackdsl("picture", "soon.yaml", "-o", "a.mp4", PATH="")
    assert result.code == 4
    assert "install ffmpeg" in result.err
    assert not (falls / "a.mp4").exists()


def test_picture_reports_the_error_of_ffmpeg(
    falls: Path, stackdsl: Stackdsl, tmp_path_factory: pytest.TempPathFactory
) -> None:
    pytest.importorskip("resvg_py")
    program = tmp_path_factory.mktemp("bin") / "ffmpeg"
    program.write_text("#!/bin/sh\necho no encoder here >&2\nexit 1\n", encoding="utf-8")
    program.chmod(0o755)
    result = stackdsl("picture", "soon.yaml", "-o", "a.mp4", "--slower", "10", PATH=str(program.parent))
    assert result.code == 4
    assert "failed to write the film: no encoder here" in result.err
    assert not (falls / "a.mp4").exists()


def test_colours_of_joints_tell_which_gives_way_first_and_how_much_the_others_use(
    stackdsl: Stackdsl, tmp_path: Path
) -> None:
    corbel = """
scenario: corbel
brick: {size: [200 mm, 100 mm, 50 mm], mass: 0.2 kg}
world: {walls: [{bearing: 180 deg, distance: 0 m}]}
joints: [{bond: {tension: 0.1 MPa, cohesion: 2 MPa}}]
build: [{bricks: [{at: [100 mm, 0 mm, 1 m], name: a}, {beside: a, name: b}, {beside: b, name: c}]}]
"""
    (tmp_path / "corbel.yaml").write_text(corbel, encoding="utf-8")
    assert stackdsl("picture", "corbel.yaml", "-o", "corbel.svg", "--joints").code == 0
    legend = texts_of(drawn(tmp_path, "corbel.svg"))
    assert "a joint gives way first at 7.079 times the weight (1)" in legend  # that of a with the wall
    assert [text for text in legend if "of strength used" in text]
    assert not [text for text in legend if text.startswith("stands")]
    assert (
        "no joint that keeps its force limits the load factor"
        in stackdsl("picture", "falls.yaml", "-o", "falls.svg", "--joints").err
    )
    assert [text for text in texts_of(drawn(tmp_path, "falls.svg")) if text.startswith("has fallen")]
