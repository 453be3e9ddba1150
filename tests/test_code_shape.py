"""Functions, classes and modules stay small enough to be read: bounds on both packages as a whole."""

import ast
from collections.abc import Iterator, Sequence
from functools import cache

import pytest

from tests.paths import ROOT

# The code is read once for all, and only where that is asked for.
pytestmark = pytest.mark.xdist_group("code shape")

PACKAGES = ("stability", "stackdsl")
MODULES = {
    path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
    for package in PACKAGES
    for path in sorted((ROOT / package).rglob("*.py"))
}


@cache
def nodes() -> Sequence[tuple[str, ast.AST]]:
    """All that the code of all modules is made of."""
    return [(name, node) for name, text in MODULES.items() for node in ast.walk(ast.parse(text))]


def body_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """How many lines the body of a function has, its docstring left out."""
    body: Sequence[ast.stmt] = function.body
    if (
        isinstance(body[0], ast.Expr)
        and isinstance(body[0].value, ast.Constant)
        and isinstance(body[0].value.value, str)
    ):
        body = body[1:]
    return (body[-1].end_lineno or 0) - body[0].lineno + 1 if body else 0


def lengths() -> Iterator[int]:
    yield from (body_lines(node) for _, node in nodes() if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))


def test_half_of_all_functions_have_five_lines_at_most_and_19_of_20_have_20() -> None:
    ordered = sorted(lengths())
    assert ordered[len(ordered) // 2] <= 5
    assert ordered[int(0.95 * len(ordered))] <= 20
    assert ordered[-1] <= 60


def test_no_class_has_more_than_26_methods() -> None:  # a world has all that the protocols of engines ask for
    methods = {
        f"{name}:{node.name}": sum(isinstance(part, ast.FunctionDef) for part in node.body)
        for name, node in nodes()
        if isinstance(node, ast.ClassDef)
    }
    assert {name: count for name, count in methods.items() if count > 26} == {}
