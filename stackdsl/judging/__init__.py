"""Trace -> outcomes, and proofs of a timeline by statics; each kind of claim has its own `judge`."""
