"""Physics engines behind one protocol, `World`."""
