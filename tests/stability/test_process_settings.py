"""Garbage is looked for more seldom and linear algebra runs on one thread while we reckon, and as before afterwards."""

import gc
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from textwrap import dedent

import pytest

from stability.process_settings import SELDOM, rarely_collected
from tests.paths import ROOT

SEEN = """
    import ctypes
    from pathlib import Path

    def threads():
        import numpy, scipy.linalg
        counts = []
        for home in (Path(numpy.__file__).parent, Path(scipy.__file__).parent):
            for file in home.parent.glob(f"{home.name}.libs/*openblas*"):
                library = ctypes.CDLL(str(file))
                count = library.openblas_set_num_threads_local(1)
                library.openblas_set_num_threads_local(count)
                counts.append(count)
        return counts
    """


def told(script: str, threads: str) -> str:
    """Return the output of a script in a new process whose environment sets this number of threads."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": threads}
    code = dedent(SEEN) + dedent(script)
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    return done.stdout.strip()


@pytest.mark.parametrize("loaded", ["", "import numpy, scipy.linalg", "import numpy"])
def test_there_is_one_thread_meanwhile_and_as_many_as_before_afterwards(loaded: str) -> None:
    script = f"""
        {loaded or "pass"}
        from stability.process_settings import one_thread
        with one_thread():
            inside = threads()
            with one_thread():
                within = threads()
            again = threads()
        print(inside, within, again, threads())
        """
    seen = told(script, "2")
    if seen == "[] [] [] []":
        pytest.skip("numpy and scipy come with no OpenBLAS of their own here")
    assert seen == "[1, 1] [1, 1] [1, 1] [2, 2]"


def test_a_verdict_and_its_margins_are_reckoned_so() -> None:
    script = """
        import numpy, scipy.linalg
        from stability import Assembly, Box, Brick, Pose, margins, outcome
        from stability.analysis import acceleration_cut
        from stability.statics.prover import Prover
        seen = []
        def watched(function):
            return lambda *given, **named: (seen.append(threads()), function(*given, **named))[1]
        Prover.put = watched(Prover.put)
        import stability.analysis.acceleration_margin as module
        module.shaken = watched(module.shaken)
        assembly = Assembly()
        assembly.add(Brick("a", Box((0.1, 0.1, 0.1)), 1.0), Pose((0.0, 0.0, 0.05)))
        assembly.move("a", Pose((0.1, 0.0, 0.05)))
        margins(assembly.problem())
        print(seen, threads())
        """
    assert told(script, "2") in ("[[1, 1], [1, 1], [1, 1]] [2, 2]", "[[], [], []] []")


def test_a_sum_has_the_same_last_digit_whatever_the_environment_says() -> None:
    #   Left alone, OpenBLAS factors a matrix of 200 rows otherwise on two threads than on one.
    script = """
        import numpy as np
        from stability.process_settings import one_thread
        random = np.random.default_rng(0)
        matrix, right = random.random((200, 200)), random.random(200)
        with one_thread():
            print(np.linalg.solve(matrix, right).tobytes().hex())
        """
    assert told(script, "1") == told(script, "2")


def test_the_command_asks_for_one_thread_in_itself_and_in_its_workers() -> None:
    script = """
        import os, sys
        from unittest.mock import patch
        import stackdsl.__main__ as command
        with patch("stackdsl.cli.main.main", lambda: print(os.environ["OPENBLAS_NUM_THREADS"])):
            command.main()
        """
    assert told(script, "7") == "1"


# --- garbage ----------------------------------------------------------------------------------------------------------


@pytest.fixture(autouse=True)
def threshold() -> Iterator[None]:
    before = gc.get_threshold()
    yield
    gc.set_threshold(*before)


def test_the_collector_looks_more_seldom_only_meanwhile() -> None:
    gc.set_threshold(700, 7, 9)
    with rarely_collected():
        assert gc.get_threshold() == (SELDOM, 7, 9)
        with rarely_collected():
            pass
        assert gc.get_threshold() == (SELDOM, 7, 9)
    assert gc.get_threshold() == (700, 7, 9)


def test_a_mistake_meanwhile_changes_nothing_of_that() -> None:
    gc.set_threshold(700, 7, 9)
    with suppress(KeyError), rarely_collected():
        raise KeyError
    assert gc.get_threshold() == (700, 7, 9)


@pytest.mark.parametrize("own", [0, SELDOM + 1])
def test_a_lower_or_disabled_frequency_of_collection_is_kept(own: int) -> None:
    gc.set_threshold(own, 7, 9)
    with rarely_collected():
        assert gc.get_threshold() == (own, 7, 9)
