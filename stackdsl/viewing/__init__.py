"""Replays, pictures and reports of runs: self-contained files that load nothing from a network."""
