"""Scenario -> timeline: names, places, times and checks."""
