"""The motion of the base: recorded, by formula, and its measures."""
