"""Motion of rigid bodies, in closed form and with non-smooth contact."""
