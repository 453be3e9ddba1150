"""Scenarios in Python: build, play and judge them with the keys of the language, and get traces as arrays."""
