"""The command line. Each file has one command or one family of commands, and is imported when it is called."""
