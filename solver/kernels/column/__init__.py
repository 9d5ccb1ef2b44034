"""From the values that describe a column to its packed model: derived fields, modes, stability."""
