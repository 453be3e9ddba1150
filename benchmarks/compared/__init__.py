"""Compares test tools by running them on the needs of a team: docs/compared.md."""
