"""Checks of a column against a seismic action: motions scaled to it, demands beside limits, margin, methods by hand."""
