"""`stackdsl completion`: prints what a shell needs to complete the command."""

import click
from click.shell_completion import get_completion_class

from stackdsl.commands.terminal import write

VARIABLE = "_STACKDSL_COMPLETE"  # by which the shell asks the command itself
WHERE = {
    "bash": 'eval "$(stackdsl completion bash)" in ~/.bashrc',
    "zsh": 'eval "$(stackdsl completion zsh)" in ~/.zshrc, after compinit',
    "fish": "stackdsl completion fish > ~/.config/fish/completions/stackdsl.fish",
}


@click.command("completion", epilog="; ".join(f"{shell}: {where}" for shell, where in WHERE.items()))
@click.argument("shell", type=click.Choice(list(WHERE)))
@click.pass_context
def completion_command(context: click.Context, shell: str) -> None:
    """Print what a shell needs to complete commands, options, systems and files."""
    completion = get_completion_class(shell)
    assert completion is not None  # click knows all of WHERE
    write(completion(context.find_root().command, {}, "stackdsl", VARIABLE).source())
