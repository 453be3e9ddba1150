"""What `pip install` is to be told for the same stackdsl as is installed here, on another machine."""

import json
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, distribution

VENDORED = "./vendor/stackdsl-*.whl"  # a wheel that the project brings along, where it comes from no repository


def requirement() -> str:
    """The repository and commit that it came from, as pip noted them (PEP 610); else a wheel within the project."""
    with suppress(PackageNotFoundError, ValueError, KeyError, TypeError):
        origin = json.loads(distribution("stackdsl").read_text("direct_url.json") or "{}")
        vcs = origin["vcs_info"]
        return f"'stackdsl @ {vcs['vcs']}+{origin['url']}@{vcs['commit_id']}'"
    return VENDORED
