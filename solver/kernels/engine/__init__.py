"""What columns and structures share: tableaux, step control, modes, exchange with bodies, peaks, queue of lanes."""
