"""The results kept of a run: peaks and snapshots."""
