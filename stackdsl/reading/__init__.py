"""YAML text -> plain values with the place of each: only what is meant gets through."""
