"""The exact method: freezes and wakes bricks by proofs of statics."""
