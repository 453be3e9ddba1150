"""How what falls begins to move, and moves as long as a proof covers it: without an engine."""
