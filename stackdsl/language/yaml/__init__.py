"""YAML text -> nodes that know their place, with `extends` and `include` resolved."""
