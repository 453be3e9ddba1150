"""Writes the report of a check as a folder of pages: an index of all cases, and a replay of each."""
