"""The systems that a scenario can be played on, and the worlds that they open."""
