"""Figures in README and docs: benchmarks write results to docs/data, and the text is rendered from there."""
