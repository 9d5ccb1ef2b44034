"""Models in motion: columns and structures, their responses, and whether they can still fall."""
