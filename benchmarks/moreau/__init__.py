"""An independent reference for hits: rigid boxes with sharp edges under Moreau's impact law."""
