"""Contact detection: contact patches from the poses and shapes of bodies."""
