"""Vectors, rotations, convex polygons and the distances between boxes: geometry without physics."""
