"""A run as one self-contained HTML page that replays it: compact data, and a program that comes with the package."""
