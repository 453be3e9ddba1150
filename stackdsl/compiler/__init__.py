"""Compiles a scenario to a timeline: resolves names, places and times, and checks them."""
