"""Plays a timeline on a system, and measures the run; the result is a trace."""
