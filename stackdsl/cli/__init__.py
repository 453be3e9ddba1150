"""The command line: one command per file or family, imported when it is called."""
