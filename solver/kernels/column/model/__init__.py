"""From the numbers that describe a column to its packed model."""
