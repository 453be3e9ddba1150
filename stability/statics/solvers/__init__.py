"""Questions for a conic solver. Only its points are used, and only once arithmetic has checked them."""
