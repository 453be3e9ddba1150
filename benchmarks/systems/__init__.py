"""Speed against error: scenarios with known answers, on every system at several time steps (`make bench`)."""
