"""Writes a run as one self-contained HTML page with a viewer that replays it."""
