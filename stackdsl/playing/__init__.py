"""Timeline -> trace: the systems, the world, and the watch over every brick."""
