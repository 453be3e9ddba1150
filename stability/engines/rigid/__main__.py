"""Compiles the engine before its first use on a machine, which takes some seconds."""

from stability.engines.rigid.preparation import is_compiled

if not is_compiled():
    from stability.engines.rigid.world import compile_engine

    compile_engine()
