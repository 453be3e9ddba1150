"""The command line: finds the called command and returns its exit code."""

import faulthandler
import os
import signal
import sys
import traceback
from collections.abc import Mapping
from errno import EDQUOT, EMFILE, ENFILE, ENOMEM, ENOSPC
from importlib import import_module
from io import TextIOWrapper
from types import FrameType
from typing import Final

import click

from stability.process_settings import collect_rarely, exclude_from_collection, uncollected
from stackdsl.cli.terminal import occupy_standard_streams, show_error, silence, tell
from stackdsl.entry_points import PluginError
from stackdsl.exits import INTERRUPTS, ExitCode

# Summary of each command: the first sentence of its help. A command is imported when it is called.
COMMANDS: Final[Mapping[str, str]] = {
    "demo": "Show a tower, its proof and its fall, without writing a file in this directory.",
    "new": "Create a first scenario called NAME. An existing file is not changed.",
    "import": "Convert the boxes in FILE, written by another program, to a scenario, and print it.",
    "export": "Convert the bricks of one case of FILE to an LDraw model, and print it.",
    "run": "Play FILE, print each event as it happens, and judge the claims. Golden files are not read.",
    "check": "Play and judge the scenarios in PATHS (default: scenarios), and compare them with their golden files.",
    "explain": "Print the compiled scenario in FILE with its proofs, or the meaning of a CODE such as SD104.",
    "sheet": "Write the sheet of a load in FILE that a person signs: limits, layers, order of placing, weakest carton.",
    "picture": "Play one case of FILE and draw its end, a given time, a strip of pictures, or a film.",
    "find": "Find the largest or least value with which FILE stands, proven on both sides and without simulation.",
    "suggest": "Find changes that let a falling FILE stand: shifts, counterweights, friction, props. Each is verified.",
    "pull": "List the bricks that can be pulled out of the structure of FILE, and the longest order of pulls.",
    "order": "Find an order of building in which the structure of FILE stands after each step, or the fewest props.",
    "survive": "Compute the acceleration and tilt that the structure of FILE survives, and the part that fails first.",
    "settle": "Move the supports of FILE until the structure falls, and list its hinges and its thrust.",
    "pushover": "Push the structure of FILE over by its loads, and list the load factor by displacement.",
    "fragility": "Compute the share of samples of FILE that fall at each intensity, and fit a lognormal curve.",
    "sensitivities": "List the bricks, joints and numbers on which the margin of FILE depends most.",
    "sweep": "Judge every variant and every sample of FILE, and write a row for each, or continue such a file.",
    "golden": "List differences from golden files, and accept or reject them.",
    "init": "Create the files of a new project in DIRECTORY (default: this one). Existing files are not changed.",
    "doctor": "List installed and missing packages, how to install them, and problems of this directory.",
    "schema": "Print the JSON Schema of scenarios, for editors.",
    "completion": "Print a completion script for a shell: commands, options, systems and files.",
}

# The groups of the help, in order.
GROUPS: Final[Mapping[str, tuple[str, ...]]] = {
    "Build, run, check": (
        "demo",
        "new",
        "import",
        "export",
        "run",
        "check",
        "explain",
        "sheet",
        "picture",
    ),
    "Studies (statics only, unless FILE needs an engine)": (
        "find",
        "suggest",
        "pull",
        "order",
        "survive",
        "settle",
        "pushover",
        "fragility",
        "sensitivities",
        "sweep",
    ),
    "Golden files": ("golden",),
    "Project": (
        "init",
        "doctor",
        "schema",
        "completion",
    ),
}

EXIT_CODES: Final = (
    "0 as expected, 1 a claim failed, 2 invalid scenario, 3 golden file differs, 4 wrong use, 5 engine stopped, "
    "130 interrupted. `stackdsl COMMAND --help` has the options of a command, and `stackdsl explain SD104` the meaning "
    "of a code."
)

# The module beside this one that has `<name>_command`, where its name is not that of the command.
MODULES: Final[Mapping[str, str]] = {
    "completion": "explain",
    "doctor": "project",
    "import": "import_",
    "init": "project",
    "new": "project",
    "schema": "explain",
    **dict.fromkeys(("find", "order", "pull", "sensitivities", "suggest", "survive"), "statics"),
    **dict.fromkeys(("settle", "pushover"), "large_motion"),
}


class CommandsOnCall(click.Group):
    """A group of commands that are imported when they are called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the options before the command; `help COMMAND` is `COMMAND --help`."""
        return super().parse_args(ctx, [*args[1:], "--help"] if args[:1] == ["help"] else args)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        with uncollected():
            module = import_module(f"stackdsl.cli.{MODULES.get(cmd_name, cmd_name)}")
            command = getattr(module, f"{cmd_name}_command")
            exclude_from_collection()
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the called command. Raises click.UsageError with the name that may be meant."""
        if args[0] not in COMMANDS and not args[0].startswith("-") and not ctx.resilient_parsing:
            from stackdsl.cli.usage_errors import unknown_command  # noqa: PLC0415 -- only mistakes need it

            raise unknown_command(args[0], list(COMMANDS), ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands in the help, with their summaries, without importing them."""
        for title, names in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl([(name, COMMANDS[name]) for name in names])
        with formatter.section("Exit codes of check"):
            formatter.write_text(EXIT_CODES)


@click.group(cls=CommandsOnCall, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(None, "-V", "--version", package_name="stackdsl")
def app() -> None:
    """Play scenarios of stacked bricks, judge them, and compare them with their golden files."""
    from stackdsl.work import WorkError, work_factor  # noqa: PLC0415 -- `--help` does without

    try:
        work_factor()
    except WorkError as error:
        raise click.UsageError(str(error)) from error


def main() -> None:
    """Run the command, and report exceptions without a traceback."""
    occupy_standard_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # it is None if it was closed at the start
            stream.reconfigure(errors="replace")
    for number in INTERRUPTS:
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # `nohup` ignores SIGHUP
            signal.signal(number, _interrupt)
    # Installed plugins of pydantic must not change the meaning of a scenario, and the search for them takes time.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    collect_rarely()
    if "STACKDSL_DEBUG" in os.environ:
        faulthandler.enable()  # of a fault in native code, such as that of an engine
    sys.exit(_code_of_run())


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Interrupt once, so that repeated Ctrl-C does not lose the report."""
    for each in INTERRUPTS:
        signal.signal(each, signal.SIG_IGN)
    raise KeyboardInterrupt


def refused_by_the_system(error: Exception) -> str:
    """Return the exhausted resource of the machine that ended a command; empty otherwise."""
    if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno == ENOMEM):
        return "out of memory: free some memory, raise the limit (ulimit -v), or use fewer processes (--jobs 1)"
    if isinstance(error, OSError) and error.errno in (EMFILE, ENFILE):
        return "too many open files: raise the limit (ulimit -n), or use fewer processes (--jobs 1)"
    if isinstance(error, OSError) and error.errno in (ENOSPC, EDQUOT):
        return f"the disk is full: {error.filename or 'free some space'}"
    return ""


def _code_of_run() -> int:
    try:
        os.getcwd()
    except FileNotFoundError:
        tell("the working directory does not exist any more: change to another directory")
        return ExitCode.USAGE
    try:
        return app.main(prog_name="stackdsl", standalone_mode=False) or ExitCode.OK
    except click.exceptions.Exit as end:
        return end.exit_code
    except click.ClickException as error:
        from stackdsl.cli.usage_errors import with_remedy  # noqa: PLC0415 -- only mistakes need it

        show_error(with_remedy(error))
        return ExitCode.USAGE
    except (KeyboardInterrupt, click.Abort) as error:
        if "STACKDSL_DEBUG" in os.environ:
            traceback.print_exception(error.__cause__ or error)  # click wraps the interrupt
        tell("interrupted")
        return ExitCode.INTERRUPTED
    except Exception as error:
        return _code_of_error(error)


def _code_of_error(error: Exception) -> int:
    """Report an error that no command expects, and return the exit code."""
    if why := refused_by_the_system(error):
        tell(why)
        return ExitCode.CRASHED
    if isinstance(error.__context__, KeyboardInterrupt):  # click could not write a newline after ^C
        silence(sys.stderr)
        return ExitCode.INTERRUPTED
    if "STACKDSL_DEBUG" in os.environ:
        raise error
    if isinstance(error, PluginError):
        tell(f"Error: {error}")
        tell("Set STACKDSL_DEBUG=1 to get the traceback.")
        return ExitCode.CRASHED
    tell(f"internal error: {type(error).__name__}: {error}")
    tell("This is a bug in stackdsl. Set STACKDSL_DEBUG=1 to get a traceback, and please report it.")
    return ExitCode.CRASHED
