"""Writes the results of a check as text, JSON and other formats."""
