"""The published method: contact areas, weight passed down, leaning, impacts, and when bricks are frozen and woken."""
