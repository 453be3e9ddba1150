"""Where two convex solids touch that are not both boxes, or such a solid and a plane: by their faces and edges."""
