"""Report -> text or JSON: renderers, one a file, that compute nothing."""
