"""Measures speed against error: scenarios with known results, on every system at several time steps (`make bench`)."""
