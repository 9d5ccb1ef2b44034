"""The method of the seed paper (theory.md section 3): its first-order equations, stepped by central differences."""
