"""The columns in their plane with brittle joints: versions of kernels that are compiled for such columns only."""
