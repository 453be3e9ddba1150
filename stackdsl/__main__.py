"""`python -m stackdsl` is `stackdsl`. The imports take longest, so an interrupt must end them as it ends the rest."""

# ruff: noqa: E402 -- before anything is imported from there
import os  # which Python has imported itself
import sys


def _drop_working_directory() -> None:
    """Remove the working directory, which `python -m` adds, from the module path, unless this package is in it."""
    try:
        put_there = not sys.flags.safe_path and sys.path[0] == os.getcwd()
    except OSError:  # it is gone
        return
    if put_there and os.path.realpath(sys.path[0]) != os.path.dirname(os.path.dirname(os.path.realpath(__file__))):
        del sys.path[0]


if __name__ == "__main__":  # whoever sent the project of that directory may have put some there
    _drop_working_directory()

import signal
from contextlib import suppress
from types import FrameType

from stability.process_settings import ask_for_one_thread

INTERRUPTED = 130  # ExitCode.INTERRUPTED, which may be just what was not imported in time


def main() -> None:
    """Run the command, and import it first."""
    ask_for_one_thread()  # also in every worker: sums must not depend on how many somebody asks for
    # Processes that we start would import modules of the folder that the command is called in, before those of Python.
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
