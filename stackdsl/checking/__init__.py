"""The pipeline of `stackdsl check`: lists the cases, plays them in worker processes, judges and caches the results."""
