"""Stores the snapshot of a trace in a golden file, and compares two snapshots."""
