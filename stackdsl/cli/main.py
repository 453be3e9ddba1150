"""The command line: finds the called command and returns its exit code."""

import os
import signal
import sys
from collections.abc import Mapping
from errno import EDQUOT, EMFILE, ENFILE, ENOMEM, ENOSPC
from importlib import import_module
from io import TextIOWrapper
from types import FrameType
from typing import Final

import click

from stability.process_settings import collect_rarely, exclude_from_collection, uncollected
from stackdsl.cli.terminal import occupy_standard_streams, show_error, silence, tell
from stackdsl.exits import INTERRUPTS, ExitCode

# What each does, as its own help says in its first sentence. A command is imported when it is called.
COMMANDS: Final[Mapping[str, str]] = {
    "check": "Play and judge everything under PATHS (default: scenarios), and compare it with its golden files.",
    "completion": "Print what a shell needs to complete commands, options, systems and files.",
    "doctor": "Tell what is installed, what is missing and how to get it, and whether this directory is in order.",
    "explain": "Print what FILE was compiled to, and what statics says of it; or what a CODE such as SD104 means.",
    "find": "Find the largest or the least number with which FILE stands, proven from both sides; nothing is played.",
    "fragility": "Tell which share of the samples of FILE falls, point by point over an intensity, with a lognormal "
    "curve.",
    "golden": "Say what differs from its golden file, and accept it or not.",
    "import": "Print a scenario with the boxes of FILE, which another program wrote; tell what was moved or is wrong.",
    "init": "Write what a new project in DIRECTORY (default: this one) needs; never over an existing file.",
    "new": "Write a scenario called NAME to start from; never over an existing file.",
    "order": "Find an order in which the finished structure of FILE can be built, standing at each step, or the least "
    "props.",
    "picture": "Play one case of FILE, and draw it: at the end, at a time, as a strip, or moving.",
    "pull": "Tell which bricks of the finished structure of FILE can be pulled, and how many one after the other.",
    "run": "Play FILE, print what happens as it happens, and judge it; golden files are not looked at.",
    "schema": "Print the JSON Schema of scenarios, for editors.",
    "sensitivities": "Tell on which bricks, joints and numbers of FILE its margin depends most; nothing is played.",
    "suggest": "Find what would let FILE stand that falls: shifts, counterweights, friction, props; each is tried.",
    "survive": "Tell what the finished structure of FILE survives when it is shaken or tilted, and what gives way "
    "first.",
    "sweep": "Judge every variant and every sample of FILE, and write a row for each; called again, it goes on where "
    "it was.",
}

# The module beside this one that has `<name>_command`, where its name is not that of the command.
MODULES: Final[Mapping[str, str]] = {
    "completion": "explain",
    "doctor": "project",
    "import": "import_",
    "init": "project",
    "new": "project",
    "schema": "explain",
    **dict.fromkeys(("find", "order", "pull", "sensitivities", "suggest", "survive"), "statics"),
}


class CommandsOnCall(click.Group):
    """A group of commands that are imported when they are called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

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
        name = args[0]
        if name not in COMMANDS and not name.startswith("-") and not ctx.resilient_parsing:
            from stackdsl.diagnostics import did_you_mean  # noqa: PLC0415 -- only mistakes need it

            raise click.UsageError(f"there is no command '{name}'; {did_you_mean(name, list(COMMANDS))}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands in the help, with their summaries, without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=CommandsOnCall, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="stackdsl")
def app() -> None:
    """Play scenarios of stacked bricks, judge them, and compare them with their golden files."""
    from stackdsl.work import WorkError, work_factor  # noqa: PLC0415 -- `--help` does without

    try:
        work_factor()
    except WorkError as error:
        raise click.UsageError(str(error)) from error


def main() -> None:
    """Run the command; no traceback reaches a user."""
    occupy_standard_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # None, if it was closed from the start
            stream.reconfigure(errors="replace")
    for number in INTERRUPTS:
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # as `nohup` asks for
            signal.signal(number, _interrupt)
    # Whatever plugins of pydantic are installed, a scenario means the same; looking for them takes time, too.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    collect_rarely()
    sys.exit(_code_of_run())


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Interrupt once, so that repeated Ctrl-C does not lose the report."""
    for each in INTERRUPTS:
        signal.signal(each, signal.SIG_IGN)
    raise KeyboardInterrupt


def refused_by_the_system(error: Exception) -> str:
    """Return the exhausted resource of the machine that ended a command; empty otherwise."""
    if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno == ENOMEM):
        return "there is too little memory: free some, raise the limit (ulimit -v), or play fewer at a time (--jobs 1)"
    if isinstance(error, OSError) and error.errno in (EMFILE, ENFILE):
        return "too many files are open: raise the limit (ulimit -n), or play fewer at a time (--jobs 1)"
    if isinstance(error, OSError) and error.errno in (ENOSPC, EDQUOT):
        return f"the disk is full: {error.filename or 'free some of it'}"
    return ""


def _code_of_run() -> int:
    try:
        os.getcwd()
    except FileNotFoundError:
        tell("the directory that this was called from is gone: change to another")
        return ExitCode.USAGE
    try:
        return app.main(prog_name="stackdsl", standalone_mode=False) or ExitCode.OK
    except click.exceptions.Exit as end:
        return end.exit_code
    except click.ClickException as error:
        show_error(error)
        return ExitCode.USAGE
    except (KeyboardInterrupt, click.Abort):
        tell("interrupted")
        return ExitCode.INTERRUPTED
    except Exception as error:
        if why := refused_by_the_system(error):
            tell(why)
            return ExitCode.CRASHED
        if isinstance(error.__context__, KeyboardInterrupt):  # click failed to end the line that shows ^C
            silence(sys.stderr)
            return ExitCode.INTERRUPTED
        if "STACKDSL_DEBUG" in os.environ:
            raise
        tell(f"internal error: {type(error).__name__}: {error}")
        tell("This is a fault of stackdsl. Set STACKDSL_DEBUG=1 to see where, and please report it.")
        return ExitCode.CRASHED
