"""The check of a column against a seismic action: scaled motions, demands and limits, margin, hand methods."""
