"""Public names of the package: each is documented, and loaded only at its first use."""

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import stability
from tests.paths import ROOT

HEAVY = {"numpy", "scipy", "clarabel", "pybullet"}


def loaded_by(code: str) -> set[str]:
    """The top-level modules that are loaded once this code has run in a fresh process."""
    tail = "; import sys; print(*{name.split('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-c", code + tail], cwd=ROOT, capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_importing_the_package_loads_no_library() -> None:
    assert not HEAVY & loaded_by("import stability")


def test_the_facts_alone_load_no_library() -> None:
    assert not HEAVY & loaded_by("from stability import Box, Brick, Plane, Pose")


def test_statics_and_both_extensions_load_no_engine() -> None:
    names = "Assembly, ProvenStability, StackStability, margins"
    assert "pybullet" not in loaded_by(f"from stability import {names}")


@pytest.mark.parametrize("name", stability.__all__)
def test_every_public_name_is_documented(name: str) -> None:
    found = getattr(stability, name)
    written = inspect.getdoc(found) or ""
    assert written, f"{name} has no docstring"
    assert not written.startswith(f"{name}("), f"{name} has only the docstring that dataclasses write"


def test_type_checkers_see_the_names_where_they_are_loaded_from() -> None:
    tree = ast.parse(Path(str(stability.__file__)).read_text(encoding="utf-8"))
    seen = next(node for node in tree.body if isinstance(node, ast.If))
    imports = (node for node in seen.body if isinstance(node, ast.ImportFrom))
    homes = {alias.name: node.module for node in imports for alias in node.names}
    assert homes == stability._HOMES
    assert sorted(homes) == sorted(stability.__all__)


def test_a_name_that_is_not_public_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'stability' has no attribute 'Asembly'"):
        stability.Asembly  # type: ignore[attr-defined]  # noqa: B018 -- asking is what raises


def test_completion_offers_the_public_names() -> None:
    assert set(stability.__all__) <= set(dir(stability))
