"""What bricks are shaped like: each shape by itself in a module of its own, and what holds of every shape in a pose."""
