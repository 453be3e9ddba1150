"""`python -m stackdsl` is `stackdsl`. The imports take longest, so an interrupt must end them as it ends the rest."""

import sys

INTERRUPTED = 130  # ExitCode.INTERRUPTED, which may be just what was not imported in time


def main() -> None:
    """Run the command, and import it first."""
    try:
        from stackdsl.commands.main import main as run  # noqa: PLC0415 -- see above

        run()
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        sys.exit(INTERRUPTED)


if __name__ == "__main__":
    main()
