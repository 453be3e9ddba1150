"""Python API: builds, plays and judges scenarios with the keys of the language, and returns results as arrays."""
