"""The exact method, which freezes and wakes bricks by proofs of statics."""
