"""What to say of a run that ended before its time."""

from stackdsl.outcome import Spared


def ending_text(early: Spared) -> str:
    """When it ended, and what that spared."""
    left_out = early.actions
    undone = f"; {left_out} action{'s' * (left_out > 1)} still to come left out" if left_out else ""
    return f"ended at {early.time:.3f} s of {early.planned:.3f} s, as all that is asked is known{undone}"
