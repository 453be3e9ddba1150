"""How a command ends: its exit codes, and the signals that end it early. Known before anything else is imported."""

import signal
from enum import IntEnum

INTERRUPTS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # what a listener may turn into KeyboardInterrupt


class ExitCode(IntEnum):
    """What `stackdsl check` says to its caller."""

    OK = 0
    FAILED = 1  # an expectation failed
    INVALID = 2  # a scenario is invalid, or what it says cannot be done when its time comes
    GOLDEN = 3  # a golden file is missing, different, unreadable or obsolete
    USAGE = 4  # wrong usage, or nothing selected
    CRASHED = 5  # the engine crashed or ran out of time
    INTERRUPTED = 130
