"""Many samples of one scenario: what hands and materials make of it, and what becomes of each."""
