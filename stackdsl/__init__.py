"""StackDSL: checks scenarios of stacked bricks by proofs of statics, simulation and golden files.

From Python::

    from stackdsl import Scenario, claims, layouts, load, play

Public names are loaded at their first use, so that importing the package is fast.
"""

import sys
from importlib import import_module
from time import time
from types import FrameType
from typing import TYPE_CHECKING

from stability.process_settings import ask_for_one_thread

if TYPE_CHECKING:  # for type checkers; at run time `__getattr__` loads the same names
    from stackdsl.api import claims, impacts, layouts
    from stackdsl.api.cases import ScenarioError, load, loads
    from stackdsl.api.fragility import fragility
    from stackdsl.api.run import NotMeasuredError, Run, UncheckedWarning, play
    from stackdsl.api.run_table import Table
    from stackdsl.api.scenario import Scenario
    from stackdsl.api.single_bricks import brick, bricks, imported
    from stackdsl.api.studies import SearchError, find, margins, sensitivities, survive
    from stackdsl.api.sweep import sweep
    from stackdsl.checking.cases import Case

ask_for_one_thread(unless_set=True)  # before numpy is imported

LOADED = time()  # [s] since 1970; this process does not run code that is written later

__all__ = [
    "Case",
    "NotMeasuredError",
    "Run",
    "Scenario",
    "ScenarioError",
    "SearchError",
    "Table",
    "UncheckedWarning",
    "brick",
    "bricks",
    "claims",
    "find",
    "fragility",
    "impacts",
    "imported",
    "layouts",
    "load",
    "loads",
    "margins",
    "play",
    "sensitivities",
    "survive",
    "sweep",
]

_HOMES = {
    "Case": "stackdsl.checking.cases",
    "NotMeasuredError": "stackdsl.api.run",
    "Run": "stackdsl.api.run",
    "Scenario": "stackdsl.api.scenario",
    "ScenarioError": "stackdsl.api.cases",
    "SearchError": "stackdsl.api.studies",
    "Table": "stackdsl.api.run_table",
    "UncheckedWarning": "stackdsl.api.run",
    "brick": "stackdsl.api.single_bricks",
    "bricks": "stackdsl.api.single_bricks",
    "find": "stackdsl.api.studies",
    "fragility": "stackdsl.api.fragility",
    "imported": "stackdsl.api.single_bricks",
    "load": "stackdsl.api.cases",
    "loads": "stackdsl.api.cases",
    "margins": "stackdsl.api.studies",
    "play": "stackdsl.api.run",
    "sensitivities": "stackdsl.api.studies",
    "survive": "stackdsl.api.studies",
    "sweep": "stackdsl.api.sweep",
}
_MODULES = ("claims", "impacts", "layouts")  # of `stackdsl.api`


# Words of new users for public names.
_MEANT = {
    **dict.fromkeys(("simulate", "execute", "judge"), "play"),
    **dict.fromkeys(("read", "open", "load_yaml", "from_file", "from_yaml"), "load"),
    **dict.fromkeys(("block", "box", "plank"), "brick"),
    **dict.fromkeys(("limit", "limits", "optimize", "search"), "find"),
    **dict.fromkeys(("margin", "robustness", "stability"), "margins"),
}
# Words of the command line, which are no functions.
_COMMANDS = dict.fromkeys(
    ("run", "check"), "write `from stackdsl import load, play`, then `play(load('tower.yaml')[0])` for the first case"
)


def _unknown(name: str, caller: FrameType) -> Exception:
    """Return the error for an unknown name in the code of `caller`."""
    if caller.f_globals.get("__name__") == "importlib._bootstrap":  # which then imports a module of this name
        return AttributeError(name)
    from dis import opname  # noqa: PLC0415 -- only mistakes need it

    from stackdsl.api import words  # noqa: PLC0415 -- likewise
    from stackdsl.diagnostics import choice_text, missing_attribute  # noqa: PLC0415 -- likewise

    homes = [each for each in (words.LAYOUT_WORDS, words.CLAIM_WORDS, words.IMPACT_WORDS) if name in each.names()]
    remedy = "; or ".join(f"write `from stackdsl import {each.name}`, then `{each.name}.{name}(...)`" for each in homes)
    remedy = remedy or _COMMANDS.get(name) or choice_text(name, __all__, _MEANT)
    # Python would replace the text of an AttributeError in `from stackdsl import name`.
    if opname[caller.f_code.co_code[caller.f_lasti]] == "IMPORT_FROM":
        return ImportError(f"cannot import '{name}' from '{__name__}'; {remedy}", name=__name__)
    return missing_attribute(f"module '{__name__}'", name, remedy)


if not TYPE_CHECKING:  # with `__getattr__`, type checkers would accept any name

    def __getattr__(name: str) -> object:
        """Load a public name from its module at its first use."""
        if name in _MODULES:
            value = import_module(f"stackdsl.api.{name}")
        elif name in _HOMES:
            value = getattr(import_module(_HOMES[name]), name)
        else:
            raise _unknown(name, sys._getframe(1))
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
