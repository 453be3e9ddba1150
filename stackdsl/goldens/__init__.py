"""Trace -> snapshot <-> golden file, and what differs between two."""
