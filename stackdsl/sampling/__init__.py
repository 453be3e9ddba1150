"""Random samples of one scenario: placement errors, uncertain variables, and the outcome of each sample."""
