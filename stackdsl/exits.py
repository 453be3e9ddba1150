"""Exit codes of commands, and the signals that end a command early. Imported before everything else."""

import signal
from enum import IntEnum

INTERRUPTS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # signals that a handler turns into KeyboardInterrupt


class ExitCode(IntEnum):
    """Exit code of `stackdsl check`."""

    OK = 0
    FAILED = 1  # an expectation failed
    INVALID = 2  # a scenario is invalid, or one of its actions cannot be done when its time comes
    GOLDEN = 3  # a golden file is missing, different, unreadable or obsolete
    USAGE = 4  # wrong usage, or nothing selected
    CRASHED = 5  # the engine crashed or ran out of time
    INTERRUPTED = 130
