"""Pictures of runs without a display: drawn by own projection as SVG, which libraries turn into PNG, GIF and WebP."""
