"""What moved in a run, when and where: kept while it is played, and given as arrays afterwards."""
