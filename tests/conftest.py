"""What all tests share: the plugins under test, and how properties are tried."""

import gc
import os
import tempfile
from collections.abc import Generator

import pytest
from hypothesis import settings

# What a check remembers is signed with a key of whoever runs it: the tests have one of their own, and leave none.
_STATES = tempfile.TemporaryDirectory(prefix="stackdsl-states-")
os.environ["XDG_STATE_HOME"] = _STATES.name

pytest_plugins = ["stackdsl.pytest_plugin", "pytester", "tests.engines_at_hand", "tests.command_line", "tests.chromium"]

# The same examples every time, so that a run says something of the change and not of its luck; machines are shared, so
# no example has a deadline. `HYPOTHESIS_PROFILE=explore` looks for new ones.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect tests without the collector of garbage, and let it look at none of what they are made of later on.

    It went through all that is kept, again and again: a quarter of what it took to collect, in every process.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()
