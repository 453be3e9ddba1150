"""What a team asks of a test tool, asked of this one and of others by running them: docs/compared.md."""
