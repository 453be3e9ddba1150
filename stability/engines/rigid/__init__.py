"""A rigid-body engine of our own for convex solids, compiled by numba: small steps, exact cones, no penetration."""
