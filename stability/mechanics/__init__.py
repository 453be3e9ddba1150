"""Rigid bodies by themselves: what an impulse does to one, several as one, one about an axis."""
