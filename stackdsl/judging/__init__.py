"""Judges a trace by the claims of its scenario, and proves a timeline by statics."""
