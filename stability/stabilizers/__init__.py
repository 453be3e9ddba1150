"""Freeze what is proven to stand, wake what moves."""
