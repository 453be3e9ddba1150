"""Runs a probe in a folder of its own, and compares the output with the expected one."""

import os
import signal
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from benchmarks.compared.probes import Probe, Tool

PROJECT: Final = Path(__file__).parent.parent.parent
AMPLE: Final = 120.0  # [s] for one command


@dataclass(frozen=True, slots=True)
class Said:
    """Exit code and output of a command."""

    code: int
    text: str


Call = Callable[[Path, str], Said]


def complaints(tool: Tool, probe: Probe, folder: Path, call: Call) -> list[str]:
    """Return the differences from the expected output in words; none if the cell is correct."""
    for name, text in {**tool.files, **probe.files}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    said = [call(folder, command) for command in probe.run][-1]
    wrong = [f"ended with {said.code}, not {probe.code}"] if probe.code not in (None, said.code) else []
    wrong += [f"does not print {part!r}" for part in probe.shows if part not in said.text]
    wrong += [f"prints {part!r}" for part in probe.hides if part in said.text]
    return [f"{tool.name}: {probe.need}: `{probe.run[-1].strip()}` {each}:\n{said.text}" for each in wrong]


def environment(*programs: Path) -> Mapping[str, str]:
    """Return the environment of commands: these folders first in the path, no variables of CI, and no colours."""
    kept = {key: value for key, value in os.environ.items() if key not in ("CI", "GITHUB_ACTIONS", "PYTEST_ADDOPTS")}
    path = os.pathsep.join([*map(str, programs), kept.get("PATH", "")])
    return kept | {"PATH": path, "NO_COLOR": "1", "PROJECT": str(PROJECT), "PAGER": "cat"}


def in_shell(folder: Path, command: str, values: Mapping[str, str]) -> Said:
    """Run a shell command without standard input; on a timeout it is killed with all its descendants."""
    with subprocess.Popen(
        ["/bin/sh", "-c", command],
        cwd=folder,
        env=values,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
        start_new_session=True,
    ) as process:
        try:
            text, _ = process.communicate(timeout=AMPLE)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            text = f"{process.communicate()[0]}\nended after {AMPLE:g} s"
    return Said(process.returncode, text)
