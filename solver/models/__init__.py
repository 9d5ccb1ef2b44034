"""One column in motion: stepping it, its response, and whether it can still fall."""
