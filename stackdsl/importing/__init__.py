"""Loads in files of other programs -> bricks of a step, each with its place in that file; nothing is guessed."""
