"""Timeline -> trace: the run, what is measured of it, and the watch over every brick."""
