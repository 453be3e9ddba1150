"""Scenarios in Python: build, play, judge, and take the trace as arrays, with the words of the language."""
