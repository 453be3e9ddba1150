"""Runs `stackdsl` by `python -m stackdsl`. The imports take long, so an interrupt ends them as it ends the command."""

# ruff: noqa: E402 -- the module path is changed before the other imports
import os  # imported by Python itself already
import sys


def _drop_working_directory() -> None:
    """Remove the working directory, which `python -m` adds, from the module path, unless this package is in it."""
    try:
        put_there = not sys.flags.safe_path and sys.path[0] == os.getcwd()
    except OSError:  # it does not exist any more
        return
    if put_there and os.path.realpath(sys.path[0]) != os.path.dirname(os.path.dirname(os.path.realpath(__file__))):
        del sys.path[0]


if __name__ == "__main__":  # an untrusted project in that directory may contain Python modules
    _drop_working_directory()

import signal
from contextlib import suppress
from types import FrameType

from stability.process_settings import ask_for_one_thread

INTERRUPTED = 130  # ExitCode.INTERRUPTED, whose module may not be imported yet


def main() -> None:
    """Import the command and run it."""
    ask_for_one_thread()  # also in every worker, since sums must not depend on the number of threads
    # Otherwise child processes would import modules of the working directory before those of Python.
    os.environ["PYTHONSAFEPATH"] = "1"
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)
    try:
        from stackdsl.cli.main import main as run  # noqa: PLC0415 -- see above

        run()
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        sys.exit(INTERRUPTED)


def _end(number: int, frame: FrameType | None) -> None:
    """End at once. Nothing has begun yet, and an exception within an import or a destructor could be ignored."""
    with suppress(OSError):
        os.write(2, b"interrupted before the command began; nothing was written\n")
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
