"""Is rest the only thing that can happen to what can rest? Proven for small groups, or another start is shown."""
