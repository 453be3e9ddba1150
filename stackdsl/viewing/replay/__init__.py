"""A run as one HTML page that plays it: data in a few bytes, a program that comes with the package, and no network."""
