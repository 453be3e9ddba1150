"""Draws random samples of one scenario with placement errors and uncertain variables, and judges each sample."""
