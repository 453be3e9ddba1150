"""What `run` keeps of its runs beside what it prints: where bricks were, as arrays, and a page that plays them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stackdsl.asked_files import write_asked
from stackdsl.checking.gathering import Case
from stackdsl.commands.options import FilePath
from stackdsl.commands.terminal import tell
from stackdsl.outcome import VariantResult
from stackdsl.trace import Trace

if TYPE_CHECKING:
    from stackdsl.recording.recorder import Recorder
    from stackdsl.viewing.run_view import RunView

ON_RECORD = click.option(
    "--record", type=FilePath, help="Write where bricks were to this .npz, as numpy arrays; of one case."
)
ON_GLB = click.option("--glb", type=FilePath, help="Write the run to this .glb, for 3D programs; of one case.")
ON_HTML = click.option("--html", type=FilePath, help="Write a page to this .html that plays what happened.")


@dataclass
class Keeping:
    """What is asked for, and what was played so far."""

    record: Path | None
    html: Path | None
    glb: Path | None
    _runs: "list[RunView]" = field(default_factory=list)

    @classmethod
    def of(cls, record: Path | None, html: Path | None, glb: Path | None, selected: Sequence[Case]) -> "Keeping":
        """What is asked for of these cases. Raises UsageError for what cannot be kept."""
        for option, path in (("--record", record), ("--glb", glb)):
            if path is not None and len(selected) > 1:
                told = f"{option} keeps one run, and {len(selected)} are selected"
                raise click.UsageError(f"{told}: choose one by --system or -k, such as -k '{selected[0].name}'")
        if glb is not None and find_spec("pygltflib") is None:
            raise click.UsageError("--glb needs pygltflib, which is not installed; try: pip install 'stackdsl[gltf]'")
        for path, suffix in ((record, ".npz"), (html, ".html"), (glb, ".glb")):
            if path is not None and path.suffix.lower() != suffix:
                raise click.UsageError(f"{path}: call it {path.with_suffix(suffix)}, since that is what it will hold")
        return cls(record, html, glb)

    def recorder(self) -> "Recorder | None":
        """What records the next run, if that is needed."""
        if self.record is self.html is self.glb is None:
            return None
        from stackdsl.recording.recorder import Recorder  # noqa: PLC0415 -- most runs are not recorded

        return Recorder()

    def played(self, case: Case, trace: Trace, recorder: "Recorder | None", result: VariantResult) -> None:
        """Keep one run."""
        if recorder is None:
            return
        recording = recorder.recording()
        if self.record is not None:
            buffer = BytesIO()
            recording.save(buffer)
            write_file(self.record, buffer.getvalue())
        if self.glb is not None:
            from stackdsl.viewing.gltf import glb  # noqa: PLC0415 -- an extra

            write_file(self.glb, glb(recording))
        if self.html is not None:
            from stackdsl.viewing.run_view import view_of  # noqa: PLC0415 -- most runs are not looked at

            self._runs.append(view_of(case, trace, recording, result))

    def write(self) -> None:
        """Write the page of all runs."""
        if self.html is None or not self._runs:
            return
        from stackdsl.viewing.replay.replay_page import replay_page  # noqa: PLC0415 -- likewise

        write_file(self.html, replay_page(self._runs, self._runs[0].name).encode())


def write_file(path: Path, data: bytes) -> None:
    """Write a file that was asked for, and say so. Raises a message for people where it cannot be written."""
    try:
        write_asked(path, data)
    except OSError as error:
        raise click.ClickException(f"{path} cannot be written: {error.strerror}") from error
    tell(f"wrote {path}, {max(1, round(len(data) / 1000)):,} kB")
