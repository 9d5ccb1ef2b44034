"""What is kept of a run: peaks and snapshots."""
