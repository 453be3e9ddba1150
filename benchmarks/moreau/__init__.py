"""A reference for hits, apart from what it judges: rigid boxes with sharp edges under Moreau's impact law."""
