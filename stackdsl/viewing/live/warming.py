"""Imports what statics may need before anything is saved: libraries that solve take longer to import than to ask."""

import gc
from importlib import import_module
from typing import Final

# Imported elsewhere where a verdict first needs them, which most runs never do.
SELDOM: Final = (
    "clarabel",
    "scipy.sparse.linalg",
    "stability.geometry.polyhedra",
    "stability.motion.least_constraint",
    "stability.statics.contacts.hulls.hull_touch",
    "stability.statics.proof",
    "stability.statics.solvers.equilibrium",
    "stability.statics.solvers.mechanism",
    "stability.statics.solvers.self_stress",
)


def warm_up() -> None:
    """Import it, and let the collector of garbage pass over all that there is by now, here and in copies of this."""
    for name in SELDOM:
        import_module(name)
    gc.freeze()
