"""Sweeps of small towers, judged in this process or wherever a test wants."""

import os
import signal
from collections.abc import Callable
from concurrent.futures import Executor, Future
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

from stackdsl.checking.cases import Case
from stackdsl.studies.sweep import SweptCase, sweep
from stackdsl.studies.sweep_plan import JudgedSamples, OtherProgram, SweepPlan, judged_piece, plan_of
from stackdsl.studies.sweep_workers import Workers
from tests.scenes import compiled

SHAKY = """
scenario: shaky
samples: {samples}
seed: {seed}
build:
  - column: {{levels: 5, step: 8 mm}}
    every: 1 s
    jitter: {{position: 5 mm}}
"""
STEPS = SHAKY.replace("8 mm", '"${{step}}"') + "matrix: {{step: [2 mm, 7 mm]}}\n"


def cases(text: str = SHAKY, samples: int = 300, seed: int = 1) -> list[Case]:
    found, mistakes = compiled(text.format(samples=samples, seed=seed))
    assert mistakes == []
    return list(found)


def plan(text: str = SHAKY, samples: int = 300, seed: int = 1) -> SweepPlan:
    return plan_of(cases(text, samples, seed))


class Here(Executor):
    """Does each call at once, in this thread."""

    def submit(self, fn: Callable[..., Any], /, *args: object, **kwargs: object) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


def here() -> AbstractContextManager[Workers]:
    """Work that is done in this thread; a test gives up the processes around it, as they take seconds to start."""
    return nullcontext(Workers(Here(), lambda: 2))


def swept(asked: SweepPlan, out: Path) -> tuple[SweptCase, ...]:
    return sweep(asked, out, here)


def deadly(case: bytes, first: int, count: int, program: str) -> JudgedSamples | OtherProgram:
    """Sample 77 brings its process down as a fault in a native library does, and 200 eats up all memory."""
    if 77 in range(first, first + count):
        os.kill(os.getpid(), signal.SIGSEGV)
    if 200 in range(first, first + count):
        raise MemoryError("of sample 200")
    return judged_piece(case, first, count, program)
