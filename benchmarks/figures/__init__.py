"""Figures in README and docs: benchmarks write what they measured to docs/data, and the text is rendered from there."""
