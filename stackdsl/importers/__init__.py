"""Loads from files of other programs: read, checked, settled and written as bricks."""
