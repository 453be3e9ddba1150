"""`stackdsl demo`: a tower, its proof and its fall."""

import tempfile
import webbrowser
from pathlib import Path
from typing import Final

import click

from stackdsl.checking.cases import cases_of
from stackdsl.checking.play_case import play_case
from stackdsl.checking.results import judged
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.terminal import tell, with_known_marks, write, write_wrapped
from stackdsl.language.yaml.source import parse
from stackdsl.report.text import EventLines, run_text
from stackdsl.simulation.recording import Recorder
from stackdsl.trace import Event
from stackdsl.viewing.replay.page import replay_page
from stackdsl.viewing.run_view import view_of

NAME: Final = "demo.yaml"
PREFIX: Final = "stackdsl-demo-"
SCENARIO: Final = """\
scenario: demo
brick: kapla                  # a wooden plank, 117.6 x 23.4 x 7.8 mm
friction: 0.5
build:
  - column: {levels: 12, step: 12 mm}
    every: 1 s
expect:
  - collapses: {at: level 10}
"""


@click.command("demo", cls=ExplainedCommand)
@click.option("--open", "opened", is_flag=True, help="Open the replay in a browser.")
def demo_command(opened: bool) -> None:
    """Show a tower, its proof and its fall, without writing a file in this directory."""
    write(f"This scenario places twelve planks, each shifted by 12 mm:\n\n{SCENARIO}")
    (case,), _ = cases_of(parse(SCENARIO, NAME))
    lines, recorder = EventLines(), Recorder()

    def told(event: Event) -> None:
        for text in lines.after(event):
            write_wrapped(text)

    trace = play_case(case.timeline, case.system, on_event=told, recorder=recorder)
    for text in lines.rest():
        write_wrapped(text)
    result = judged(case, trace)
    write_wrapped(with_known_marks(run_text(trace, result)))
    write(
        "\nN planks stand while N x 12 mm is at most 117.6 mm, so the tenth is one too many.\n"
        "Each `proven to stand` is a proof: contact forces that balance every plank. The engine played only the fall."
    )
    run = view_of(case, trace, recorder.recording(), result)
    with tempfile.NamedTemporaryFile("w", encoding="utf-8", prefix=PREFIX, suffix=".html", delete=False) as page:
        page.write(replay_page([run], run.name))
    write(f"\nThe replay, with the forces of the proof: {page.name}")
    write("Next: `stackdsl new my-tower` writes a first scenario of your own.")
    if opened and not webbrowser.open(Path(page.name).as_uri()):
        tell("no browser could be opened; open the file above")
