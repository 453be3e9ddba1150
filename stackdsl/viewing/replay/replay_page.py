"""Runs -> one HTML page. It holds its program, its style and its data, and is allowed to ask for nothing else.

What comes from a scenario is data: it stands in a script of JSON, in which `<` is written as an escape, and the program
puts it on the page as text. The policy in the head lets nothing run but the two programs whose hashes it names.
"""

import base64
import hashlib
import json
from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from string import Template
from typing import Final

from stackdsl.viewing.replay.packing import deflated
from stackdsl.viewing.replay.payload import payload_of
from stackdsl.viewing.run_view import RunView

# Inflates the program and lets it run: it is four times as long as that.
LOADER: Final = (
    "(async()=>{const b=Uint8Array.from(atob(document.getElementById('program').textContent),c=>c.charCodeAt(0));"
    "const s=document.createElement('script');"
    "s.textContent=await new Response(new Blob([b]).stream().pipeThrough(new DecompressionStream('deflate'))).text();"
    "document.body.append(s)})()"
)
LIVE_POLICY: Final = "; connect-src 'self'"


def replay_page(runs: Sequence[RunView], title: str) -> str:
    """The page that plays these runs, two of them side by side if that is wanted."""
    return page_of([told(run) for run in runs], title)


def live_page(title: str) -> str:
    """A page that hears of its runs from where it was loaded, and of each again whenever it has changed."""
    return page_of([], title, live=True)


def told(run: RunView, hurried: bool = False) -> str:
    """What a page is told of a run, as JSON in one line; see `payload_of`."""
    return json.dumps(payload_of(run, hurried), separators=(",", ":"), allow_nan=False)


def page_of(runs: Sequence[str], title: str, live: bool = False) -> str:
    """The page of runs that are `told`."""
    program, style = program_and_style()
    return Template(_packaged("replay.html")).substitute(
        title=escape(title),
        policy=policy_of((LOADER, program), (style,)) + (LIVE_POLICY if live else ""),
        live=" data-live" if live else "",
        style=style,
        licence=_packaged("replay.LICENSE.txt"),
        program=deflated(program.encode()),
        loader=LOADER,
        data=harmless(f"[{','.join(runs)}]"),
    )


def harmless(data: str) -> str:
    """JSON that ends no script and begins no comment of HTML, whatever texts are in it."""
    return data.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _packaged(name: str) -> str:
    return files("stackdsl.viewing.replay").joinpath(name).read_text(encoding="utf-8")


def program_and_style() -> tuple[str, str]:
    """What every page that plays runs is made of, beside the LOADER."""
    return _packaged("replay.js"), _packaged("replay.css")


def policy_of(scripts: Iterable[str], styles: Iterable[str]) -> str:
    """The content security policy by which these scripts run and these styles hold, and nothing else does."""
    run, hold = (" ".join(map(hash_of, texts)) for texts in (scripts, styles))
    return f"default-src 'none'; script-src {run}; style-src {hold}; base-uri 'none'; form-action 'none'"


def hash_of(text: str) -> str:
    """How a content security policy names a script or a style that stands in the page."""
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
    return f"'sha256-{digest}'"
