"""`stackdsl picture` draws a run to a file, in the form that its name says."""

import shutil
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from tests.command_line import GOOD, Stackdsl

FALLS = GOOD.replace("levels: 3", "levels: 6, step: 21 mm").replace("stands: all", "collapses: any")
SOON = FALLS.replace("levels: 6, step: 21 mm", "levels: 3, step: 44 mm").replace("1 s", "0.1 s")  # few pictures
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(autouse=True)
def falls(tmp_path: Path) -> Path:
    (tmp_path / "falls.yaml").write_text(FALLS, encoding="utf-8")
    (tmp_path / "soon.yaml").write_text(SOON, encoding="utf-8")
    return tmp_path


def drawn(folder: Path, name: str) -> ET.Element:
    return ET.fromstring((folder / name).read_text(encoding="utf-8"))


def test_each_view_is_a_panel_and_each_brick_is_drawn_by_its_name(falls: Path, stackdsl: Stackdsl) -> None:
    assert stackdsl("picture", "falls.yaml", "-o", "a.svg", "--at", "4.5", "--forces").code == 0
    panels = drawn(falls, "a.svg").findall(f"{SVG}svg")
    captions = [text.text for panel in panels for text in panel.iter(f"{SVG}text")]
    assert captions == [f"good[exact], {view}, 4.5 s" for view in ("three-quarter", "front", "plan")]
    for panel in panels:
        names = {title.text for title in panel.iter(f"{SVG}title")}
        assert names == {f"L{level}.1" for level in range(1, 6)}  # those that had come by then
    assert len(list(panels[1].iter(f"{SVG}line"))) > 5  # arrows


def test_a_strip_shows_how_it_falls(falls: Path, stackdsl: Stackdsl) -> None:
    assert stackdsl("picture", "falls.yaml", "-o", "a.svg", "--strip", "4", "--view", "front").code == 0
    panels = drawn(falls, "a.svg").findall(f"{SVG}svg")
    shapes = [sorted(shape.get("points", "") for shape in panel.iter(f"{SVG}polygon")) for panel in panels]
    assert len(panels) == 4
    assert len({str(points) for points in shapes}) == 4


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


def test_of_several_cases_it_says_which_one_it_draws_and_how_to_choose_another(falls: Path, stackdsl: Stackdsl) -> None:
    (falls / "two.yaml").write_text(GOOD.replace("expect:", "systems: [exact, thesis]\nexpect:"), encoding="utf-8")
    result = stackdsl("picture", "two.yaml", "-o", "a.svg", "--at", "0.5")
    assert (
        "drawing good[exact], the first of 2; choose another with --system or -k, such as -k 'good[thesis]'"
        in result.err
    )
    again = stackdsl("picture", "two.yaml", "-o", "b.svg", "--at", "0.5", "-k", "good[thesis]")
    assert "drawing" not in again.err
    assert "good[thesis], front, 0.5 s" in (falls / "b.svg").read_text(encoding="utf-8")


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
    result = stackdsl("picture", "soon.yaml", "-o", "a.mp4", PATH=str(program.parent))
    assert result.code == 4
    assert "failed to write the film: no encoder here" in result.err
    assert not (falls / "a.mp4").exists()
