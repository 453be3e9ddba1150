"""Processes that carry out tasks under supervision: what crashes, or takes too much, costs that task and no other."""
