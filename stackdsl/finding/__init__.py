"""The numbers with which a scenario just stands, and what its margin depends on most."""
