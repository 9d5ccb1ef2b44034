"""The motion of the base: records, formulas, and measures of intensity."""
