"""Reads YAML text into values with their places, and resolves `extends` and `include`."""
