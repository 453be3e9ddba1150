"""The machine code of the rigid-body engine: whether it has to be made first."""

import subprocess
import sys

import pytest


def test_an_engine_that_numba_is_told_to_interpret_is_not_compiled_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    program = (
        "from stability.engines.rigid import preparation; preparation._is_in = lambda folder: False;"
        "print(preparation.is_compiled())"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (run.stdout.strip(), run.stderr) == ("True", "")
