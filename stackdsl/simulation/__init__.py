"""Timeline -> trace: the systems that play a scenario, and all measurements during a run."""
