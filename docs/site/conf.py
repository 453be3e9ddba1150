"""The site of the documentation: README, the pages of docs, and the Python API from its docstrings.

The source folder is the root of the repository, so that the links of the pages work on the site as they do in a
checkout. Build it with `make docs`.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Final

from sphinx.application import Sphinx

ROOT: Final = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]  # our packages, and our extension of Sphinx

from benchmarks.figures.gallery import Scene, scenes

project = "StackDSL"
version = re.search(r'^version = "(.*)"', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)[1]
project_copyright = author = "The StackDSL authors"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx_copybutton", "docstrings", "terms"]
root_doc = "README"
include_patterns = [
    *("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "stackdsl/diagnostics.md"),
    *("docs/*.md", "docs/guides/*.md", "docs/design/*.md", "docs/measurements/*.md", "docs/api/*.rst"),
]
suppress_warnings = [
    "toc.not_included",  # pages for contributors have links, and no place in the navigation
    "config.cache",  # a function of ours, which templates call
]
myst_heading_anchors = 4
autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
default_role = "code"  # of single backticks in docstrings
autodoc_preserve_defaults = True
autosummary_ignore_module_all = False
templates_path = [str(Path(__file__).parent / "templates")]

html_theme = "furo"
html_title = f"StackDSL {version}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False

# The navigation: groups of pages, in order.
GROUPS: Final = {
    "Start": ["install", "tutorial", "gallery", "limits", "choose", "README"],
    "Guides by reader": [
        *("guides/pallets", "guides/packer", "guides/masonry", "guides/earthquake", "guides/robot-assembly"),
        *("guides/engine-developers", "guides/teachers", "guides/games"),
    ],
    "How to": [
        "seeing",
        "loads",
        "records",
        "protocols",
        "python-api",
        "your-own-pybullet-world",
        "own-engine",
        "scale",
    ],
    "Reference": ["command", "language", "formats", "units", "columns", "../stackdsl/diagnostics", "api", "glossary"],
    "Background": [
        *(
            "physics",
            "joints",
            "load-core",
            "systems",
            "speed-against-error",
            "benchmarks",
            "moving-part",
            "method",
            "cite",
        ),
        *("../SECURITY", "../CHANGELOG", "../CONTRIBUTING"),
    ],
}
REPLAYS: Final = "replays"
SHOWN: Final = "jenga-exact"  # the replay on the home page
HOME: Final = "## Install"  # it stands above this heading


def with_navigation(app: Sphinx, docname: str, source: list[str]) -> None:
    """Add the navigation to the home page, and a link to its replay to each scene of the gallery."""
    if docname == root_doc:
        source[0] = source[0].replace(
            HOME, f'<iframe class="replay" src="{REPLAYS}/{SHOWN}.html" title="A replay"></iframe>\n\n{HOME}'
        )
        for caption, pages in GROUPS.items():
            lines = "\n".join(str(Path("docs", page)) if not page.startswith("..") else page[3:] for page in pages)
            source[0] += f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{lines}\n```\n"
    elif docname == "docs/gallery":
        for scene in scenes(source[0]):
            link = f'<p><a class="replay" href="../{REPLAYS}/{scene.name}.html">Play it</a></p>'
            command = rf"`stackdsl run [^`\n]* --html {re.escape(scene.name)}\.html` replays it\."
            source[0] = re.sub(command, rf"{link}\n\n\g<0>", source[0])


def play(scene: Scene, folder: Path) -> None:
    """Write the replay page of a scene."""
    file, case = f"scenarios/{scene.strip.file}", scene.strip.case
    command = [sys.executable, "-m", "stackdsl", "run", file, "-k", case, "--html", str(folder / f"{scene.name}.html")]
    subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def with_replays(app: Sphinx, error: Exception | None) -> None:
    """Write the replays of the gallery, and the name under which browsers look for a home page."""
    if error is not None or app.builder.name != "html":
        return
    folder = Path(app.outdir, REPLAYS)
    folder.mkdir(exist_ok=True)
    for scene in scenes((ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")):
        play(scene, folder)
    shutil.copyfile(Path(app.outdir, "README.html"), Path(app.outdir, "index.html"))


def setup(app: Sphinx) -> None:
    """Attach the functions above; pages of classes that are gone would be read again."""
    shutil.rmtree(ROOT / "docs" / "api", ignore_errors=True)
    app.connect("source-read", with_navigation)
    app.connect("build-finished", with_replays)
