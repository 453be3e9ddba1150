"""The gallery shows the scenarios as they are, and a picture of each."""

from benchmarks.figures.gallery import PAGE, scenes, with_scenarios


def test_the_gallery_shows_the_present_text_of_each_scenario() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert with_scenarios(page) == page, "write it anew with `python -m benchmarks.figures.gallery`"


def test_the_gallery_has_23_scenes_with_a_picture_each() -> None:
    shown = scenes(PAGE.read_text(encoding="utf-8"))
    assert len(shown) == 23
    assert [scene.title for scene in shown if not scene.picture.exists()] == []
