"""Stabilizers, which freeze the bricks that are proven to stand and wake the bricks that must move."""
