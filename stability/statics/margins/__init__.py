"""How far a verdict is from flipping."""
