"""The places of all numbers in the flat arrays."""
