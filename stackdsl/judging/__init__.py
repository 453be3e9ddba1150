"""Trace -> outcomes, and what statics say of a run; how each kind of claim is judged, the kind itself says."""
