"""The published method: base model, leaning, impacts."""
