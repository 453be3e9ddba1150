"""`python -m stackdsl` is `stackdsl`. The imports take longest, so an interrupt must end them as it ends the rest."""

# ruff: noqa: E402 -- before anything is imported from there
import os  # imported at the start of Python already
import sys


def _drop_working_directory() -> None:
    """Remove the working directory, which `python -m` adds, from the module path, unless this package is in it."""
    try:
        put_there = not sys.flags.safe_path and sys.path[0] == os.getcwd()
    except OSError:  # the directory was deleted
        return
    if put_there and os.path.realpath(sys.path[0]) != os.path.dirname(os.path.dirname(os.path.realpath(__file__))):
        del sys.path[0]


if __name__ == "__main__":  # a downloaded project may contain modules of the same names
    _drop_working_directory()

import signal
from contextlib import suppress
from types import FrameType

from stability.process_settings import ask_for_one_thread

INTERRUPTED = 130  # ExitCode.INTERRUPTED, whose import may have been interrupted


def main() -> None:
    """Run the command, and import it first."""
    ask_for_one_thread()  # also in every worker: sums must not depend on the number of threads
    # Child processes would import modules of the working directory before those of Python.
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
    """End at once: nothing is begun yet, and where Python forgets things an error would be told, and passed over."""
    with suppress(OSError):
        os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
