"""Trace -> snapshot <-> golden file."""
