"""Reads YAML text into values with their source positions, and resolves `extends` and `include`."""
