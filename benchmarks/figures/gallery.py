"""The gallery: scenes of `scenarios/` with picture and YAML, in docs/gallery.md; `make pictures`, a minute.

The page names the file, the case and the number of pictures of each scene. What stands between that line and the end of
the scene is written here.
"""

import re
from pathlib import Path
from typing import Final, NamedTuple

from rich.console import Console
from rich.progress import track

from benchmarks.figures.pages import ROOT
from benchmarks.figures.strips import Strip, drawn

PAGE: Final = ROOT / "docs" / "gallery.md"
PICTURES: Final = ROOT / "docs" / "pictures" / "gallery"
SCENE: Final = re.compile(
    r"## (?P<title>[^\n]*)\n[^#]*?"
    r"<!-- scene: (?P<file>\S+) (?P<case>\S+); (?P<view>[\w-]+), (?P<count>\d+) -->\n(?P<shown>.*?)<!-- end -->",
    re.DOTALL,
)


class Scene(NamedTuple):
    """One scene of the gallery; one panel shows the end of the run."""

    title: str
    strip: Strip

    @property
    def name(self) -> str:
        """Return the name for files."""
        return self.strip.path.stem

    @property
    def picture(self) -> Path:
        """Return the path of its picture."""
        return PICTURES / f"{self.name}.svg"


def scenes(page: str) -> list[Scene]:
    """Return the scenes of a page, in order."""
    return [_scene(found) for found in SCENE.finditer(page)]


def _scene(found: re.Match[str]) -> Scene:
    return Scene(found["title"], Strip(found["file"], found["case"], found["view"], int(found["count"])))


def with_scenarios(page: str) -> str:
    """Return the page with the picture and the present YAML of each scene."""

    def written(found: re.Match[str]) -> str:
        scene = _scene(found)
        before = found[0][: found.start("shown") - found.start()]
        return f"{before}{_shown(scene)}<!-- end -->"

    return SCENE.sub(written, page)


def _shown(scene: Scene) -> str:
    file, case = scene.strip.file, scene.strip.case
    picture = scene.picture.relative_to(PAGE.parent)
    return (
        f"![{scene.title}]({picture})\n\n"
        f"<details><summary>The scenario</summary>\n\nFrom [{file}](../scenarios/{file}):\n\n"
        f"<!-- shown: {file} -->\n```yaml\n{document(scene)}\n```\n\n</details>\n\n"
        f"`stackdsl run scenarios/{file} -k '{case}' --html {scene.name}.html` replays it.\n"
    )


def document(scene: Scene) -> str:
    """Return the document of a scene in its file, without leading comments."""
    text = (ROOT / "scenarios" / scene.strip.file).read_text(encoding="utf-8")
    name = scene.strip.case.partition("[")[0]
    found = next(
        part for part in re.split(r"^---\n", text, flags=re.M) if re.search(rf"^scenario: {name}$", part, re.M)
    )
    return found[found.index("scenario:") :].rstrip()


def main() -> None:
    """Draw every scene, and write the page."""
    page = PAGE.read_text(encoding="utf-8")
    PICTURES.mkdir(parents=True, exist_ok=True)
    for scene in track(scenes(page), "drawing"):
        scene.picture.write_text(drawn(scene.strip), encoding="utf-8")
    PAGE.write_text(with_scenarios(page), encoding="utf-8")
    Console().print(f"wrote {PAGE.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
