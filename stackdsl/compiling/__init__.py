"""Scenario -> timeline: what is placed when and where, and whether it fits."""
