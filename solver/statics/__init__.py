"""The column on a still base: balance, capacity, modes, free rocking, calibration."""
