"""Stabilizers: freeze bricks that are proven to stand, and wake bricks that move."""
