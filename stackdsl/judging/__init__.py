"""Trace -> findings: one module a subject, one function a kind of claim."""
