"""What people look at: replays, pictures and reports of runs, each one file that asks nothing of any network."""
