"""What docs/compared.md says of this tool is run, row by row, so that no row can go stale; so is what checks it."""

import shlex
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.compared.__main__ import shown, tables
from benchmarks.compared.asking import Said, complaints, environment, in_shell
from benchmarks.compared.probes import FOLDER, NOT_TRIED, OWN, Probe, Tool, needs, read_tool, tools
from benchmarks.figures.data import load
from tests.command_line import Stackdsl
from tests.engines_at_hand import needs_pybullet
from tests.paths import ROOT

STACKDSL = read_tool(FOLDER / "stackdsl.yaml")
OF_A_SHELL = set("|<>&;$*\n")  # what a command cannot do without one
ALL = [need for group in needs().values() for need in group]


# What waits for something, or starts several programs; tests of the room of each say the same without waiting.
SLOW = (
    "watch files and rerun",
    "a crash fails one test only",
    "a hang fails one test only",
    "Ctrl-C leaves a report of finished tests",
    "write tests in a programming language",
)


def in_a_shell(command: str) -> bool:
    """Whether it takes programs of its own, each a second."""
    return not command.startswith("stackdsl ") or bool(OF_A_SHELL & set(command))


def own_rows() -> list[object]:
    """Each with the name of what is needed; those on PyBullet only where there is one."""
    return [
        pytest.param(
            probe,
            id=need,
            marks=[needs_pybullet] * ("tuned" in str(probe.files))
            + [pytest.mark.slow] * (need in SLOW or any(map(in_a_shell, probe.run))),
        )
        for need, probe in STACKDSL.probes.items()
    ]


@pytest.mark.parametrize("probe", own_rows())
def test_the_command_of_a_row_does_what_the_row_says(probe: Probe, tmp_path: Path, stackdsl: Stackdsl) -> None:
    def call(folder: Path, command: str) -> Said:
        if not in_a_shell(command):
            result = stackdsl(*shlex.split(command)[1:])
            return Said(result.code, result.text)
        return in_shell(folder, command, values)

    values = {**environment(Path(sys.executable).parent), "PYTHONPATH": str(ROOT)}
    assert complaints(STACKDSL, probe, tmp_path, call) == []


def test_each_need_has_a_row_of_ours() -> None:
    assert list(STACKDSL.probes) == ALL


@pytest.mark.parametrize("tool", list(tools()), ids=lambda tool: tool.name)
def test_a_cell_is_what_was_seen_when_its_probe_was_run(tool: Tool) -> None:
    written = load("compared").tables
    for group, asked in needs().items():
        cells = {need: str(written[group][need][tool.name]) for need in asked}
        says = {need: shown(tool.probes[need]) if need in tool.probes else NOT_TRIED for need in asked}
        assert cells == says, f"ask again: python -m benchmarks.compared --only {tool.name} --write"


def test_a_row_is_wrong_if_its_command_ends_or_prints_otherwise(tmp_path: Path) -> None:
    tool = replace(STACKDSL, files={})
    probe = Probe("stop", "`-x`", run=["first", "last"], code=1, shows=["1 failed"], hides=["2 failed"])

    def found(code: int, text: str) -> list[str]:
        return complaints(tool, probe, tmp_path, lambda folder, command: Said(code, f"{command}: {text}"))

    assert found(1, "1 failed") == []
    assert [each.splitlines()[0] for each in found(0, "2 failed")] == [
        "StackDSL: stop: `last` ended with 0, not 1:",
        "StackDSL: stop: `last` does not print '1 failed':",
        "StackDSL: stop: `last` prints '2 failed':",
    ]


@pytest.mark.parametrize("row", ["{cell: 'no'}", "{cell: 'no', run: tool --help}", "{cell: 'yes', code: 1}"])
def test_a_cell_that_nothing_checks_is_refused(row: str, tmp_path: Path) -> None:
    (tmp_path / "needs.yaml").write_text("group: [speed]\n", encoding="utf-8")
    (tmp_path / "tool.yaml").write_text(f"tool: a\nversion: a\nrows:\n  speed: {row}\n", encoding="utf-8")
    with pytest.raises(ValueError, match="speed: nothing checks what its cell says"):
        read_tool(tmp_path / "tool.yaml")


def test_a_row_that_nobody_needs_is_refused(tmp_path: Path) -> None:
    (tmp_path / "needs.yaml").write_text("group: [speed]\n", encoding="utf-8")
    text = "tool: a\nversion: a\nrows:\n  sped: {cell: 'yes', documented: manual}\n"
    (tmp_path / "tool.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"not in needs\.yaml: sped"):
        read_tool(tmp_path / "tool.yaml")


def test_a_tool_that_is_not_at_hand_keeps_its_cells() -> None:
    need = ALL[0]
    before = {"tools": {"Vitest": {"version": "4"}}, "choosing": {need: {"Vitest": "`-t`", OWN: "old"}}}
    found = tables({OWN: {need: "new"}}, {OWN: {"version": "1"}}, before)
    assert (found["choosing"][need]["Vitest"], found["choosing"][need][OWN]) == ("`-t`", "new")
    assert found["choosing"][need]["Hurl"] == NOT_TRIED
    assert found["tools"]["Vitest"] == {"version": "4"}


def test_a_command_that_hangs_is_ended_with_all_that_it_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class OutOfTime(subprocess.Popen[str]):
        """A process whose time is over as soon as it has begun."""

        def communicate(self, input: str | None = None, timeout: float | None = None) -> tuple[str, str]:
            while not (tmp_path / "there").exists():
                time.sleep(0.01)
            return super().communicate(input, None if timeout is None else 0.01)

    monkeypatch.setattr("benchmarks.compared.asking.subprocess.Popen", OutOfTime)
    said = in_shell(tmp_path, "echo begun; touch there; sleep 600 & wait", environment())
    assert said.code != 0
    assert said.text == "begun\n\nended after 120 s"
