"""Whole runs: one, one with its check and ensemble, many at once."""
