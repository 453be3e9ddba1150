"""Studies of one scenario: limits, sensitivities, fragility curves and sweeps."""
