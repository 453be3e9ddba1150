"""Questions for a conic solver, of which only the points are used, and only once they are checked."""
