"""Geometry without physics: vectors, rotations, convex polygons and solids, and distances between them."""
