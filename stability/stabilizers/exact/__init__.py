"""The exact method: freezes and wakes by proofs of statics."""
