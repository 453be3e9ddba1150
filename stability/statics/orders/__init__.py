"""In which orders the bricks of a design may come and go, every state on the way proven."""
