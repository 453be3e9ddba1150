"""Exact statics: proves that an assembly of bricks stands or falls, without an engine."""
