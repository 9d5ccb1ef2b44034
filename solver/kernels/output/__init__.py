"""Results kept of a run: peaks and snapshots."""
