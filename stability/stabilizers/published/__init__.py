"""The published method: base model, leaning model and impact model."""
