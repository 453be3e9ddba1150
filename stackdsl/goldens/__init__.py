"""Trace -> snapshot <-> golden file, and the differences of two snapshots."""
