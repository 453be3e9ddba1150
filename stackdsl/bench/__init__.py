"""`stackdsl bench`: every scenario with a known answer, on every system, at several time steps; speed against error."""
