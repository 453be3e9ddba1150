"""Errors of a call with their remedies, which come from the options, the help and the examples of its command."""

import os
import shlex
import sys
from collections.abc import Iterator, Sequence
from typing import Final

import click

from stackdsl.cli.command_help import EXAMPLES, TOPICS
from stackdsl.diagnostics import did_you_mean, meant_choice

# Words of new users for commands.
MEANT: Final = {
    **dict.fromkeys(("test", "verify", "validate", "lint", "judge"), "check"),
    **dict.fromkeys(("play", "simulate", "replay", "view", "watch"), "run"),
    **dict.fromkeys(("draw", "render", "plot", "image"), "picture"),
    **dict.fromkeys(("create", "add"), "new"),
    **dict.fromkeys(("convert", "load", "read"), "import"),
    **dict.fromkeys(("limit", "optimize", "optimise", "search", "max"), "find"),
    **dict.fromkeys(("fix", "repair", "improve"), "suggest"),
    **dict.fromkeys(("margin", "margins", "robustness", "stability"), "survive"),
}


# Words of new users for options.
MEANT_OPTIONS: Final = {
    **dict.fromkeys(("max", "maximum", "maximize", "maximise", "highest", "biggest"), ("largest", "most")),
    **dict.fromkeys(("min", "minimum", "minimize", "minimise", "lowest", "smallest"), ("least",)),
    **dict.fromkeys(("filter", "select", "grep", "match", "only", "case", "name"), ("k",)),
    **dict.fromkeys(("engine", "backend", "simulator", "solver", "on"), ("system",)),
    **dict.fromkeys(("output", "save", "o"), ("out",)),
    **dict.fromkeys(("threads", "workers", "parallel", "processes", "n"), ("jobs",)),
    **dict.fromkeys(("timeout", "max-time", "limit"), ("time-limit",)),
    **dict.fromkeys(("precision", "tolerance", "tol", "eps"), ("accuracy", "within")),
    **dict.fromkeys(("type", "json", "csv"), ("format",)),
    **dict.fromkeys(("update-golden", "accept", "bless", "overwrite"), ("update",)),
    **dict.fromkeys(("graph", "figure", "chart", "draw"), ("plot",)),
}


def unknown_command(name: str, commands: Sequence[str], context: click.Context) -> click.UsageError:
    """Return the error for an unknown command: the name that may be meant, or the commands for a file."""
    if os.path.exists(name) or name.lower().endswith((".yaml", ".yml")):
        file = shlex.quote(name)
        remedy = f"write `stackdsl run {file}` to play this file, or `stackdsl check {file}` to check it"
    else:
        remedy = did_you_mean(name, commands, MEANT) or "`stackdsl --help` lists the commands"
    return click.UsageError(f"unknown command '{name}'; {remedy}", context)


def with_remedy(error: click.ClickException) -> click.ClickException:
    """Return an error of click with a remedy. Errors of commands have one already: the part after a semicolon."""
    context = error.ctx if isinstance(error, click.UsageError) else None
    if context is None:
        return error
    if isinstance(error, click.NoSuchOption):
        return click.UsageError(_unknown_option(error.option_name, context), context)
    if not isinstance(error, click.BadParameter | click.BadOptionUsage) or ";" in error.message:
        return error
    parameter = error.param if isinstance(error, click.BadParameter) else None
    if isinstance(error, click.BadOptionUsage):
        parameter = next((each for each in context.command.params if error.option_name in each.opts), None)
    return click.UsageError("\n".join([error.format_message(), *_explained(parameter, context)]), context)


def _unknown_option(name: str, context: click.Context) -> str:
    """Return the message for an unknown option: the option that is meant, its place, or all options."""
    command = context.command
    path = context.command_path.removeprefix("stackdsl").strip()
    if isinstance(command, click.Group):
        words = sys.argv[1 + len(path.split()) :]
        called = next((word for word in words if word in command.list_commands(context)), "")
        if called:
            words.remove(called)
            return f"options follow the command; write `{context.command_path} {called} {shlex.join(words)}`"
    options = [each for each in command.get_params(context) if isinstance(each, click.Option)]
    names = [each for option in options for each in (*option.opts, *option.secondary_opts)]
    by_word = {each.lstrip("-"): each for each in names}
    known = [each for each in MEANT_OPTIONS.get(name.lstrip("-").lower(), ()) if each in by_word]
    if len(known) > 1:
        lines = [_help_of(option, context) for option in options if {*option.opts} & {by_word[each] for each in known}]
        return "\n".join([f"No such option '{name}'; write one of:", *lines])
    if meant := next(iter(known), "") or meant_choice(name.lstrip("-"), list(by_word)):
        return f"No such option '{name}'; did you mean '{by_word[meant]}'?"
    common = {each for topic in TOPICS.values() for each in topic}
    own = [option for option in options if option.name not in {*common, "help"}]
    head = f"No such option '{name}'; `{context.command_path} --help` lists all options, among them:"
    return "\n".join([head, *(_help_of(option, context) for option in own)])


def _explained(parameter: click.Parameter | None, context: click.Context) -> Iterator[str]:
    """Yield the help of a parameter, and a call that has it."""
    if parameter is not None and (line := _help_of(parameter, context)):
        yield line
    names = parameter.opts if isinstance(parameter, click.Option) else []
    calls = list(EXAMPLES.get(context.command.name or "", ()))
    fitting = [call for call in calls if {*names} & {*call.split()}] if names else calls
    yield from (f"  example: {call}" for call in fitting[:1])


def _help_of(parameter: click.Parameter, context: click.Context) -> str:
    record = parameter.get_help_record(context)
    return f"  {record[0]:<20}  {record[1]}" if record is not None and record[1] else ""
