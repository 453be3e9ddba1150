"""A parser of somebody else that hangs, crashes or eats memory costs the file that it reads, and nothing else."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.command_line import AMPLE
from tests.paths import ROOT

# A MuJoCo that does what the name of the model says, in place of the real one, which not every machine has.
FAKE = """
import os, signal, time
from pathlib import Path


def set_mju_user_warning(_):
    pass


class MjSpec:
    @staticmethod
    def from_string(xml, assets):
        Path("begun").write_text(str(os.getpid()))
        if "hangs" in xml:
            for number in (signal.SIGINT, signal.SIGTERM):
                signal.signal(number, signal.SIG_IGN)
            time.sleep(600.0)
        if "crashes" in xml:
            os.kill(os.getpid(), signal.SIGSEGV)
        if "leaves" in xml:
            os._exit(5)
        if "eats" in xml:
            held = [bytes(1 << 28) for _ in range(1000)]
        raise RuntimeError("no such word")
"""
MJCF = '<mujoco><worldbody><body name="{}"><freejoint/><geom type="box" size="1 1 1"/></body></worldbody></mujoco>'
IMPORTED = "scenario: {0}\nbuild:\n  - import: {{file: {0}.xml, format: mjcf}}\n"
SOUND = "scenario: sound\nbuild:\n  - column: {levels: 2}\nexpect:\n  - stands: all\n"
CHECK = """
import sys
from stackdsl.__main__ import main
from stackdsl.importers import supervised_reading
supervised_reading.TIME_LIMIT = float(sys.argv[1])
sys.argv = ["stackdsl", "check", "."]
main()
"""
BROKEN = {
    "crashes": "the worker was killed by SIGSEGV",
    "leaves": "the worker exited with code 5",
    "eats": "MemoryError",
    "raises": "RuntimeError: no such word",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "fakes" / "mujoco").mkdir(parents=True)
    (tmp_path / "fakes" / "mujoco" / "__init__.py").write_text(FAKE, encoding="utf-8")
    (tmp_path / "sound.yaml").write_text(SOUND, encoding="utf-8")
    return tmp_path


def put(folder: Path, name: str) -> None:
    (folder / f"{name}.xml").write_text(MJCF.format(name), encoding="utf-8")
    (folder / f"{name}.yaml").write_text(IMPORTED.format(name), encoding="utf-8")


def checking(folder: Path, limit: float) -> subprocess.Popen[str]:
    paths = os.pathsep.join([str(folder / "fakes"), str(ROOT)])
    return subprocess.Popen(
        [sys.executable, "-c", CHECK, str(limit)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": paths, "CI": ""},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def test_a_file_that_hangs_its_parser_is_told_and_all_other_scenarios_are_reported(folder: Path) -> None:
    put(folder, "hangs")
    running = checking(folder, 0.5)
    said, _ = running.communicate(timeout=AMPLE)
    assert (
        "hangs.xml:1:1: SD114 the file takes too long to read: took longer than 0.5 s (imported from hangs.yaml:3:5)"
        in said
    )
    assert "1 passed" in said
    assert running.returncode == 2


@pytest.mark.slow  # four workers that import scipy, one after the other
def test_files_that_break_their_parser_are_told_and_all_other_scenarios_are_reported(folder: Path) -> None:
    for name in BROKEN:
        put(folder, name)
    running = checking(folder, AMPLE)
    said, _ = running.communicate(timeout=2 * AMPLE)
    for name, told in BROKEN.items():
        assert f"{name}.xml:1:1: SD114 the file crashes its reader: {told}" in said
    assert "1 passed" in said
    assert "1 passed, 4 mistakes" in said
    assert running.returncode == 2


@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_an_interrupt_ends_a_check_whose_parser_hangs_and_ignores_it(folder: Path, number: signal.Signals) -> None:
    put(folder, "hangs")
    running = checking(folder, 600.0)
    deadline = time.monotonic() + AMPLE
    while not (folder / "begun").exists() and running.poll() is None and time.monotonic() < deadline:
        time.sleep(0.02)
    running.send_signal(number)
    running.communicate(timeout=AMPLE)
    assert running.returncode in {130, -number}
