"""Check for the engine's machine code, which exists after its first use or `python -m stability.engines.rigid`."""

from logging import getLogger
from pathlib import Path


def is_compiled() -> bool:
    """Check that the machine code of the engine is kept, if possible without importing the compiler."""
    if _is_in(Path(__file__).parent / "__pycache__"):
        return True
    from numba import config  # noqa: PLC0415 -- the compiler takes a while to import

    if config.DISABLE_JIT:
        return True  # nothing will be compiled
    from stability.engines.rigid.mechanics import advance  # noqa: PLC0415 -- the same

    return _is_in(Path(getattr(advance, "stats").cache_path))  # noqa: B009 -- of the compiler, unknown to type checkers


def _is_in(folder: Path) -> bool:
    return any(folder.glob("mechanics.advance-*.nbi"))


def tell_if_compiling() -> None:
    """Log a warning if the next step will compile the engine first."""
    if not is_compiled():
        getLogger(__name__).warning("Compiling the engine for this machine, once; this takes about 25 s.")
