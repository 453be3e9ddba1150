"""Contact patches from the poses and shapes of bodies."""
