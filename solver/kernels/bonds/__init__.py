"""Columns in their plane with brittle joints: what kernels of other columns leave out."""
