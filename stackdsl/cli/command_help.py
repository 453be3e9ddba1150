"""The help of a command: its own options, then those of many commands by topic, and two examples."""

import os
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import click

# Options that many commands have, by parameter name. All others are the command's own.
TOPICS: Final[Mapping[str, tuple[str, ...]]] = {
    "Selection": ("keyword", "systems", "tags", "shard", "only_failed", "only_changed", "list_only"),
    "Output": (
        *("form", "outputs", "plot", "html", "glb", "record", "output", "out"),
        *("quiet", "verbose", "verbosity", "table", "every_case", "durations", "all_names"),
    ),
    "Golden files": ("golden", "no_golden", "update", "accept_failing"),
    "Processes": ("jobs", "time_limit", "cache", "executor", "scheduler"),
}

# Two calls of each command, with their purpose.
EXAMPLES: Final[Mapping[str, Mapping[str, str]]] = {
    "demo": {
        "stackdsl demo": "a tower, its proof and its fall, in a minute",
        "stackdsl demo --open": "the same, with the replay in a browser",
    },
    "new": {
        "stackdsl new tower": "writes scenarios/tower.yaml",
        "stackdsl new tower --to drafts": "writes drafts/tower.yaml",
    },
    "import": {
        "stackdsl import cartons.csv --friction 0.4 > load.yaml": "boxes of a table, with units in its heading",
        "stackdsl import arch.obj --density '2400 kg/m3'": "blocks of a mesh",
    },
    "export": {
        "stackdsl export bridge.yaml > bridge.ldr": "a model of LEGO bricks, for LDraw viewers",
        "stackdsl export bridge.yaml -k span=12": "one variant of a file",
    },
    "run": {
        "stackdsl run tower.yaml --html tower.html": "plays every case, and writes a replay",
        "stackdsl run tower.yaml -k levels=8 --watch": "a page that follows each save of the file",
    },
    "check": {
        "stackdsl check": "all of scenarios/, against claims and golden files",
        "stackdsl check scenarios/tower.yaml --html report": "one file, with a report page",
    },
    "explain": {
        "stackdsl explain tower.yaml": "where each brick lies, and what proves it",
        "stackdsl explain sd104": "the meaning of an error code",
    },
    "picture": {
        "stackdsl picture tower.yaml -o tower.svg --at 2.5": "the state at 2.5 s, from three sides",
        "stackdsl picture tower.yaml -o fall.png --strip 6": "six moments of the motion",
    },
    "find": {
        "stackdsl find arch.yaml --least thickness": "the thinnest arch that stands",
        "stackdsl find tower.yaml --most levels --to 40": "the largest number of levels, up to 40",
    },
    "suggest": {
        "stackdsl suggest tower.yaml": "changes with which each case stands",
        "stackdsl suggest tower.yaml -k levels=8": "the same for one case",
    },
    "pull": {
        "stackdsl pull jenga.yaml": "which bricks may go, and in which order",
        "stackdsl pull jenga.yaml --single": "each brick alone, without orders",
    },
    "order": {
        "stackdsl order arch.yaml": "an order with the fewest props",
        "stackdsl order arch.yaml --no-props": "an order without props, or a proof that none exists",
    },
    "survive": {
        "stackdsl survive load.yaml": "acceleration and tilt, by direction",
        "stackdsl survive load.yaml --plot load.svg": "the same, drawn",
    },
    "settle": {
        "stackdsl settle arch.yaml": "hinges and thrust until the arch falls",
        "stackdsl settle arch.yaml --plot arch.svg --format csv": "the thrust by movement, drawn and as a table",
    },
    "pushover": {
        "stackdsl pushover wall.yaml": "the load factor by displacement",
        "stackdsl pushover wall.yaml --plot wall.svg --format csv": "the curve, drawn and as a table",
    },
    "fragility": {
        "stackdsl fragility shaky.yaml --over acceleration --bearing 0": "by constant acceleration along +x",
        "stackdsl fragility shaky.yaml --over jitter --from '1 mm' --to '8 mm'": "by error of placement",
    },
    "sensitivities": {
        "stackdsl sensitivities tower.yaml": "on what the survived acceleration depends",
        "stackdsl sensitivities tower.yaml --of friction --top 5": "on what the least friction depends",
    },
    "sweep": {
        "stackdsl sweep shaky.yaml --out rows.jsonl": "a row for each sample; the same call goes on",
        "stackdsl sweep shaky.yaml --out rows.csv --samples 500": "500 samples of each case, as CSV",
    },
    "status": {
        "stackdsl golden status": "all pending changes",
        "stackdsl golden status -k tower": "those of some cases",
    },
    "review": {
        "stackdsl golden review": "asks for each change",
        "stackdsl golden review -k tower": "asks for those of some cases",
    },
    "accept": {
        "stackdsl golden accept -k tower": "the changes of some cases",
        "stackdsl golden accept": "all pending changes",
    },
    "reject": {
        "stackdsl golden reject -k tower": "the changes of some cases",
        "stackdsl golden reject": "all pending changes",
    },
}
WIDEST: Final = 40  # [characters] of an example beside its purpose


def _too_many(context: click.Context) -> str:
    name = context.command_path.removeprefix("stackdsl ")
    taken = [each.human_readable_name for each in context.command.params if isinstance(each, click.Argument)]
    return f"{name} takes only {' and '.join(taken)}" if taken else f"{name} has no arguments"


class ExplainedCommand(click.Command):
    """A command whose help lists options by topic, and examples."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options: the command's own first."""
        topic_of = {name: topic for topic, names in TOPICS.items() for name in names}
        rows: dict[str, list[tuple[str, str]]] = {"Options": [], **{topic: [] for topic in TOPICS}}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None and isinstance(parameter, click.Option):
                rows[topic_of.get(parameter.name or "", "Options")].append(record)
        for topic, records in rows.items():
            if records:
                with formatter.section(topic):
                    formatter.write_dl(records)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the call. Raises click.UsageError, which has a remedy, for arguments that the command does not take."""
        ctx.allow_extra_args = True
        try:
            super().parse_args(ctx, args)
        except click.UsageError as error:
            error.ctx = error.ctx or ctx  # click gives none for an option without its value
            raise
        if ctx.args and not ctx.resilient_parsing:
            raise click.UsageError(f"{_too_many(ctx)}; {self._instead(ctx)}", ctx)
        return ctx.args

    def _instead(self, context: click.Context) -> str:
        """Return what to write in place of arguments that the command does not take."""
        takes_file = any(isinstance(each, click.Argument) for each in self.params)
        if takes_file and all(map(os.path.exists, context.args)):
            return f"call `{context.command_path}` once for each file"
        if any(each.name == "keyword" for each in self.params):
            words = " or ".join(Path(word).stem or word for word in context.args)
            return f"write -k {shlex.quote(words)} to select cases by name"
        return f"remove {shlex.join(context.args)}, or put a value with spaces in quotes"

    def get_short_help_str(self, limit: int = 45) -> str:
        """Return the first sentence of the help, whole."""
        return (self.help or "").partition(". ")[0].strip().rstrip(".") + "."

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the examples, then the epilog."""
        if examples := EXAMPLES.get(self.name or ""):
            with formatter.section("Examples"):
                formatter.write_dl(list(examples.items()), col_max=WIDEST)
        super().format_epilog(ctx, formatter)
