"""Timeline -> trace: the systems that play a scenario, and everything that is measured meanwhile."""
