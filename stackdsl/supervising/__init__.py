"""Supervised worker processes: a task that crashes, or exceeds its memory or time, affects no other task."""
