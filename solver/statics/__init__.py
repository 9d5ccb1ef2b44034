"""The column without motion of the base: balance, capacity, modes, free rocking, calibration."""
