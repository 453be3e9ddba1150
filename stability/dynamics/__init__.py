"""Motion of rigid bodies without an engine: its onset, toppling as one body, drops and landings."""
