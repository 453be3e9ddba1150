"""The architecture, as a test: which room may import from which, and that one file knows each engine.

A package is laid out in rooms (its folders) and doors (its modules at the top). Each may import from what stands on a
lower layer, and from nothing that stands beside or above it. Inside a room files may import each other as they like, as
long as no two end up in a circle.
"""

import ast
import subprocess
import sys
from collections.abc import Iterator
from functools import cache

import pytest

from tests.paths import ROOT

# From the facts up to the shell; what stands on one layer does not know each other.
LAYERS = {
    "stability": (
        {"model", "notebook", "work_limit"},
        {"graph", "geometry", "name_order", "process_settings"},
        {"contact_law"},
        {"problem"},
        {"contacts", "joints", "loads", "strength", "supports"},
        {"ties"},
        {"statics"},
        {"analysis", "dynamics"},
        {"engines"},
        {"stabilizers"},
    ),
    "stackdsl": (
        {"disk", "shown_text"},
        {"diagnostics", "entry_points", "exits", "project_file", "timeline", "wording", "work"},
        {"user_files", "supervising"},
        # A claim judges a trace, so what happened is plain data below the language.
        {"trace"},
        {"language", "results", "simulation"},
        {"compiler", "goldens", "packing"},
        {"importers"},  # a load settles on the bricks of earlier steps
        {"judging", "sampling"},
        {"checking"},
        {"studies"},
        {"report"},
        {"viewing"},
        {"api"},
        {"built_files", "cli", "pytest_plugin"},
        {"__main__"},
    ),
}
FILES = sorted(path for package in LAYERS for path in (ROOT / package).rglob("*.py"))
MODULES = {".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path for path in FILES}
LAYER_OF = {
    f"{package}.{room}": n for package, layers in LAYERS.items() for n, rooms in enumerate(layers) for room in rooms
}


@cache
def imported(module: str) -> tuple[str, ...]:
    """The modules that one imports, each by the name of its file."""
    return tuple(_imported(module))


def _imported(module: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(MODULES[module].read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            of_package = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from [name for name in of_package if name in MODULES] or [node.module]


def room_of(module: str) -> str:
    return ".".join(module.split(".")[:2])


def test_every_room_has_a_layer_and_exists() -> None:
    assert {room_of(module) for module in MODULES} - LAYERS.keys() == LAYER_OF.keys()


def test_rooms_import_only_from_lower_layers() -> None:
    upward = [
        f"{module} imports from {other}, which is no lower layer"
        for module in MODULES
        if (own := room_of(module)) in LAYER_OF  # not the package itself, whose public names are loaded at first use
        for other in sorted({room_of(name) for name in imported(module)} & LAYER_OF.keys() - {own})
        if other.split(".")[0] == own.split(".")[0] and LAYER_OF[other] >= LAYER_OF[own]
    ]
    assert upward == []


@pytest.mark.parametrize("package", LAYERS)
def test_no_modules_import_each_other_in_a_circle(package: str) -> None:
    inside = [module for module in MODULES if module.startswith(f"{package}.")]
    below = {module: set(imported(module)) & MODULES.keys() for module in inside}
    while free := {module for module, others in below.items() if not others & below.keys()}:
        below = {module: others for module, others in below.items() if module not in free}
    assert below == {}


def test_no_room_takes_a_public_name_from_the_package_which_would_load_what_is_above() -> None:
    assert [module for module in MODULES if "stackdsl" in imported(module)] == ["stackdsl.checking.cache"]  # its time


def test_stability_does_not_know_the_language() -> None:
    offenders = {m for m in MODULES if m.startswith("stability") and any(n.startswith("stackdsl") for n in imported(m))}
    assert offenders == set()


ENGINES = pytest.mark.parametrize("engine", ["pybullet", "mujoco"])


@ENGINES
def test_one_file_imports_the_engine(engine: str) -> None:
    users = [module for module in MODULES if any(name.split(".")[0] == engine for name in imported(module))]
    assert users == [f"stability.engines.{engine}.binding"]


@ENGINES
def test_one_package_knows_the_engine_and_all_else_asks_it(engine: str) -> None:
    package = f"stability.engines.{engine}"
    users = {m for m in MODULES if any(name.startswith(f"{package}.binding") for name in imported(m))}
    assert all(user.startswith(package) for user in users)


def test_the_command_line_starts_without_the_engine() -> None:
    engines = {"pybullet", "mujoco"}
    code = f"import sys, stackdsl.cli.main; sys.exit(bool({engines} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0
