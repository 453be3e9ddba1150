"""Importers, which read, check and settle loads from files of other programs, and write them as bricks."""
