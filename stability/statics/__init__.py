"""Exact statics: does an assembly of bricks stand? A verdict with its proof, without any engine."""
