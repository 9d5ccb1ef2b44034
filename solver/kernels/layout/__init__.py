"""The layout of all numbers in the flat arrays."""
