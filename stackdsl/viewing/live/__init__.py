"""A page on this machine that shows runs anew whenever their file is saved."""
