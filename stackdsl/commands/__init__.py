"""The command line: thin shells around the pipeline, one module a command."""
