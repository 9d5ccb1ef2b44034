"""What lies where in the flat arrays."""
