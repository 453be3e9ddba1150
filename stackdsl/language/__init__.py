"""The language of scenarios: YAML values, layouts, claims, impacts, and their validation."""
