"""What all tests share: the plugins under test, and how properties are tried."""

import os

from hypothesis import settings

pytest_plugins = ["stackdsl.pytest_plugin", "pytester", "tests.command_line", "tests.engines_at_hand"]

# The same examples every time, so that a run says something of the change and not of its luck; machines are shared, so
# no example has a deadline. `HYPOTHESIS_PROFILE=explore` looks for new ones.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))
